#ifndef DARBOUX_SOLVER_BASE64_H_
#define DARBOUX_SOLVER_BASE64_H_

#include <string>

namespace darboux {

// RFC 4648, section 4, with padding.
std::string Base64(const std::string& bytes);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_BASE64_H_
