#include "tools/html_report.h"

#include <glog/logging.h>

#include <cstddef>

#include "solver/base64.h"

namespace darboux {

// Written by tools/report/build.mjs, or a stub where there is no npm: null.
extern const char* const kReportPage[];
extern const std::size_t kReportPageParts;

namespace {

constexpr char kTitleMark[] = "<!--darboux:title-->";
constexpr char kDataMark[] = "<!--darboux:data-->";

}  // namespace

bool HasReportPage() { return kReportPageParts > 0; }

std::string NoReportPage() {
  return "--report: found a build without the report's page; allowed where Darboux was configured "
         "with npm installed and DARBOUX_BUILD_REPORT=ON, and npm could get its packages";
}

std::string JsonForHtml(const nlohmann::ordered_json& json) {
  const std::string text =
      json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size() + text.size() / 16);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '<') {
      safe += "\\u003c";
    } else if (c == '>') {
      safe += "\\u003e";
    } else if (c == '&') {
      safe += "\\u0026";
    } else if (text.compare(i, 3, "\xe2\x80\xa8") == 0 || text.compare(i, 3, "\xe2\x80\xa9") == 0) {
      safe += text[i + 2] == '\xa8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string TextForHtml(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string MakeReportHtml(const Report& report) {
  CHECK(HasReportPage());
  std::string page;
  for (std::size_t i = 0; i < kReportPageParts; ++i) page += kReportPage[i];
  const std::size_t title = page.find(kTitleMark), data = page.find(kDataMark);
  CHECK(title != std::string::npos && data != std::string::npos && title < data);

  nlohmann::ordered_json header = report.header;
  header["version"] = DARBOUX_VERSION;
  // Text that is no UTF-8 is replaced where JSON is written; the title goes the same way.
  const nlohmann::ordered_json name = nlohmann::ordered_json::parse(
      header["name"].dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  std::string html =
      page.substr(0, title) + TextForHtml(name.get<std::string>()) +
      page.substr(title + sizeof(kTitleMark) - 1, data - title - sizeof(kTitleMark) + 1);
  html += "<script type=\"application/json\" id=\"darboux-header\">" + JsonForHtml(header) +
          "</script>\n";
  const std::vector<std::string>& blobs = report.arrays.blobs();
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    html += "<script type=\"text/plain\" id=\"darboux-" + std::to_string(i) + "\">" +
            Base64(blobs[i]) + "</script>\n";
  }
  return html + page.substr(data + sizeof(kDataMark) - 1);
}

}  // namespace darboux
