#ifndef DARBOUX_TOOLS_HELP_H_
#define DARBOUX_TOOLS_HELP_H_

#include <gflags/gflags.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

// The manual of a tool, from one source: what its Tool says and the texts of its flags. --help
// prints it, --help=man writes it as a page for man(1).
//
// The text of a flag has four parts between bars with a space on each side,
//
//   DEFINE_double(time_limit, 0.0, "solver | SECONDS | >= 0 s; 0: none | Stops the solver after.");
//                                   group    value     range, unit       what it does
//
// The group is one of kGroups in help.cc. The value stands behind the flag's name ("=SECONDS"); a
// switch has none. Type and default are added by themselves, the latter not where the range says
// "default" or "required". A flag with a text of another form is listed last, under "Other".

namespace darboux {

// A term and its explanation: an argument, a file, an exit status; or a command and what it does.
struct HelpItem {
  const char* term;
  const char* text;
};

// A list of these which has static storage: constexpr HelpItem kFiles[] = {{...}, {...}};
class HelpItems {
 public:
  constexpr HelpItems() = default;
  template <std::size_t N>
  constexpr HelpItems(const HelpItem (&items)[N]) : items_(items), size_(N) {}
  constexpr const HelpItem* begin() const { return items_; }
  constexpr const HelpItem* end() const { return items_ + size_; }

 private:
  const HelpItem* items_ = nullptr;
  std::size_t size_ = 0;
};

struct Tool {
  const char* name;                // "darboux_deform"
  const char* usage;               // "SCENE.yaml --out=DIR [flags]"
  const char* description;         // paragraphs, with an empty line between them
  int num_arguments;               // besides the flags
  const char* purpose = "";        // "deforms a shell": follows the name
  HelpItems arguments = {};        // what stands in their places
  HelpItems files = {};            // what is written, in the folder of --out
  HelpItems exit_statuses = {};    // "0": done
  const char* signals = "";        // what SIGINT and SIGTERM do
  HelpItems examples = {};         // the command, run in a clone of the project; what it does
  const char* without_flags = "";  // common flags that it does not have, joined by commas
};

// Flags that are defined in the tools' folder and linked into this program, without those that the
// tool says it does not have; by name.
std::vector<gflags::CommandLineFlagInfo> OwnFlags(const Tool& tool);

// At most 80 columns, in bold letters where `bold`.
std::string HelpText(const Tool& tool, bool bold);

// Source of a page of section 1, in the macros of man(7).
std::string ManPage(const Tool& tool);

// Whether bold letters are welcome: a terminal that knows them, and no NO_COLOR.
bool WantsBold(std::FILE* to);

// "darboux_deform 0.1.0", and in a second line the libraries that it was built with.
std::string VersionText(const Tool& tool);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_HELP_H_
