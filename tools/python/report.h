#ifndef DARBOUX_TOOLS_PYTHON_REPORT_H_
#define DARBOUX_TOOLS_PYTHON_REPORT_H_

#include "solver/report_view.h"
#include "solver/results.h"

namespace darboux {

// report.html, of write(report=True).

// InputError where this module was built without the page.
void RequireReportPage();
// The file.
NamedFile ReportFile(const Report& report);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_REPORT_H_
