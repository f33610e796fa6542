#ifndef DARBOUX_GEOMETRY_NEAREST_NAME_H_
#define DARBOUX_GEOMETRY_NEAREST_NAME_H_

#include <string>
#include <vector>

namespace darboux {

// What counts as a misspelling.
enum class Spelling {
  // Keys, flags and words: a letter in the wrong case is one mistake, two swapped letters are two.
  kWord,
  // Names in a formula: case does not matter, two swapped neighbours are one mistake, and no two
  // letters are taken for a name of one letter (uv is u * v, not a misspelt u).
  kFormula,
};

// The known name with the smallest edit distance to the one found, the first of several; empty
// when none is similar: a third of the bytes may be wrong, or one in a short name of two or more.
std::string NearestName(const std::string& found,
                        const std::vector<std::string>& known,
                        Spelling spelling = Spelling::kWord);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_NEAREST_NAME_H_
