#ifndef DARBOUX_TOOLS_COMMAND_LINE_H_
#define DARBOUX_TOOLS_COMMAND_LINE_H_

#include <string>
#include <vector>

#include "tools/help.h"

// The command line of all tools, in place of gflags' own: --help shows the tool's manual and only
// its flags; a mistake ends with status 2 and says what is allowed.

namespace darboux {

// Exit status of the tools.
enum ExitStatus {
  kExitDone = 0,          // converged, and every `expect` holds
  kExitNotConverged = 1,  // or an `expect` fails, or results could not be written
  kExitBadInput = 2       // command line or scene; nothing was written
};

// Sets the flags that the command line names, as --flag=value, --flag value or -flag=value;
// --flag and --noflag for true and false; after "--" all are arguments. True: run. False: end with
// *exit_status; help or version are on stdout, a mistake, the number of arguments included, on
// stderr in one line and the usage.
// Flags known besides the tool's own: glog's v, vmodule, minloglevel, logtostderr and their kin.
// `versions`: of libraries besides those of VersionText, ", Ceres 2.1.0".
bool ParseWords(const Tool& tool,
                const std::string& versions,
                int argc,
                char** argv,
                std::vector<std::string>* arguments,
                int* exit_status);

// Prints a mistake on the command line and the usage to stderr. Always false.
bool FailUsage(const Tool& tool, const std::string& message, int* exit_status);

// Whether the command line has set a flag.
bool IsGiven(const char* flag);

// A tool's main: its Run, whose exit status it returns. The project throws nothing; the libraries
// below it do where memory ends, which is said in one line and ends with status 1.
int RunTool(const Tool& tool, int (*run)(int argc, char** argv), int argc, char** argv);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_COMMAND_LINE_H_
