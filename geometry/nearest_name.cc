#include "geometry/nearest_name.h"

#include <algorithm>
#include <cstddef>

namespace darboux {
namespace {

std::string Lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

// Insertions, deletions and replacements that turn a into b (Levenshtein); `swaps`: a swap of
// neighbours is one step as well.
std::size_t EditDistance(const std::string& a, const std::string& b, bool swaps) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
      if (swaps && i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string NearestName(const std::string& found,
                        const std::vector<std::string>& known,
                        Spelling spelling) {
  const bool formula = spelling == Spelling::kFormula;
  // Anything longer resembles nothing.
  const std::size_t longest = formula ? 40 : 64;
  if (found.empty() || found.size() > longest) return "";
  const std::size_t limit = found.size() < 2 ? 0 : std::max<std::size_t>(found.size() / 3, 1);
  std::size_t smallest = limit + 1;
  std::string nearest;
  for (const std::string& name : known) {
    if (name.size() > found.size() + limit) continue;  // However long it is.
    const std::size_t distance = formula ? EditDistance(Lower(found), Lower(name), /*swaps=*/true)
                                         : EditDistance(found, name, /*swaps=*/false);
    if (distance >= smallest || (formula && distance >= name.size())) continue;
    smallest = distance;
    nearest = name;
  }
  return nearest;
}

}  // namespace darboux
