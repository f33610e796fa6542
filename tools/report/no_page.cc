// In place of the report's page where there is no npm to make it with.

#include <cstddef>

namespace darboux {

extern const char* const kReportPage[];
extern const std::size_t kReportPageParts;
const char* const kReportPage[] = {nullptr};
const std::size_t kReportPageParts = 0;

}  // namespace darboux
