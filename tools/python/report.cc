#include "tools/python/report.h"

#include "tools/python/convert.h"
#ifdef DARBOUX_HAVE_HTML_REPORT
#include "tools/html_report.h"
#endif

namespace darboux {

void RequireReportPage() {
#ifdef DARBOUX_HAVE_HTML_REPORT
  if (HasReportPage()) return;
#endif
  throw InputError(
      "report: found a build without the report's page; allowed where Darboux was configured with "
      "its tools and npm, and npm could get its packages");
}

NamedFile ReportFile([[maybe_unused]] const Report& report) {
#ifdef DARBOUX_HAVE_HTML_REPORT
  return {kReportFile, MakeReportHtml(report)};
#else
  return {"report.html", ""};  // RequireReportPage has thrown.
#endif
}

}  // namespace darboux
