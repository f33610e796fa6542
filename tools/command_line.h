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

// Sets the flags that the words of a command line name, as --flag=value, --flag value or
// -flag=value; --flag and --noflag for true and false; after "--" all are arguments. True: run.
// False and an empty *error: help or version are on stdout, and there is nothing else to do. False
// and *error: a mistake, in one line, the number of arguments included.
// Flags known besides the tool's own: glog's v, vmodule, minloglevel, logtostderr and their kin.
// `versions`: of libraries besides those of VersionText, ", Ceres 2.1.0".
bool ParseWords(const Tool& tool,
                const std::string& versions,
                const std::vector<std::string>& words,
                std::vector<std::string>* arguments,
                std::string* error);

// What follows a mistake, on stderr.
void PrintUsage(const Tool& tool);

// Whether the command line has set a flag.
bool IsGiven(const char* flag);

// The exit status of a tool's Run. The project throws nothing; the libraries below it do where
// memory ends, which is status 1 and said in *error.
int RunAndCatch(int (*run)(int argc, char** argv), int argc, char** argv, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_COMMAND_LINE_H_
