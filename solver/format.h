#ifndef DARBOUX_SOLVER_FORMAT_H_
#define DARBOUX_SOLVER_FORMAT_H_

#include <cstdio>
#include <string>

namespace darboux {

// Numbers in the words of reports and verdicts. `format`: of printf, for up to three doubles.
inline std::string Format(const char* format, double a, double b = 0.0, double c = 0.0) {
  char text[256];
  std::snprintf(text, sizeof(text), format, a, b, c);
  return text;
}
inline std::string Percent(double part) { return Format("%.2g %%", 100.0 * part); }
inline std::string Number(double value) { return Format("%.4g", value); }

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FORMAT_H_
