#ifndef DARBOUX_TOOLS_HTML_REPORT_H_
#define DARBOUX_TOOLS_HTML_REPORT_H_

#include <string>

#include "solver/file_set.h"
#include "solver/report_view.h"
#include "solver/results.h"

namespace darboux {

// A report as one HTML file that opens from disk and asks no network: the page of tools/report,
// which is compiled in, with the data filled in.

constexpr char kReportFile[] = "report.html";

// Whether this program was built with the page: it needs npm at build time.
bool HasReportPage();
// What to tell somebody who asks for a report where it was not.
std::string NoReportPage();

// The file's contents. Requires HasReportPage. The header becomes a script element of type
// application/json, in which nothing can end the element or begin a comment, whatever names the
// scene has; each array's bytes one of type text/plain, in base64. The page's policy runs no script
// but its own, whose hash it names.
std::string MakeReportHtml(const Report& report);

// The two halves of it, for tests.
// JSON without '<', '>', '&' and the line ends of JavaScript that are none of JSON: written \uXXXX.
std::string JsonForHtml(const nlohmann::ordered_json& json);
// Text with '<', '>', '&' and quotes as character references.
std::string TextForHtml(const std::string& text);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_HTML_REPORT_H_
