#ifndef DARBOUX_SOLVER_FORMAT_H_
#define DARBOUX_SOLVER_FORMAT_H_

#include <cstdio>
#include <string>

namespace darboux {

// Numbers in the words of reports and verdicts. `format`: of printf, for one double.
inline std::string Format(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}
inline std::string Percent(double part) { return Format("%.2g %%", 100.0 * part); }
inline std::string Number(double value) { return Format("%.4g", value); }

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FORMAT_H_
