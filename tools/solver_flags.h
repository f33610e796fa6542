#ifndef DARBOUX_TOOLS_SOLVER_FLAGS_H_
#define DARBOUX_TOOLS_SOLVER_FLAGS_H_

#include <gflags/gflags.h>

#include <atomic>
#include <string>
#include <vector>

#include "solver/scene.h"
#include "solver/shell_solver.h"
#include "tools/command_line.h"

// Flags that the tools which solve have in common.

DECLARE_string(out);
DECLARE_bool(quiet);
DECLARE_bool(report);
DECLARE_string(log);

namespace darboux {

// Sets the flags that the command line names, as --flag=value, --flag value or -flag=value;
// --flag and --noflag for true and false; after "--" all are arguments. True: run. False: end with
// *exit_status; help or version are on stdout, a mistake on stderr in one line and the usage.
// Flags known besides the tool's own: glog's v, vmodule, minloglevel, logtostderr and their kin.
// Starts glog: warnings and errors, to stderr only, whatever the flags say; and progress.
bool ParseCommandLine(
    const Tool& tool, int argc, char** argv, std::vector<std::string>* arguments, int* exit_status);

// A tool's main: its Run, whose exit status it returns. The project throws nothing; the libraries
// below it do where memory ends, which is said in one line and ends with status 1. The last event
// of --log=json is its.
int RunTool(const Tool& tool, int (*run)(int argc, char** argv), int argc, char** argv);

// What is wrong, in one line on stderr; both return the exit status: kExitBadInput and
// kExitNotConverged.
int BadInput(const std::string& message);
int NotDone(const std::string& message);

// False and *error: "--FLAG: found 'its value'; allowed ALLOWED".
bool FailFlag(const char* flag, const std::string& allowed, std::string* error);

// Whether the folder of --out can be written to, to be asked before time is spent on solving.
bool CheckOut(std::string* error);

// Reads a scene, with its mesh mended where --repair is given; prints what was mended to stderr, a
// line for each thing, unless --quiet is given. False and *error as ReadScene.
bool ReadSceneToMend(const std::string& file, Scene* scene, std::string* error);
// The same and ApplyFlags.
bool ReadSceneWithFlags(const std::string& file,
                        Scene* scene,
                        std::vector<std::string>* overridden,
                        std::string* error);

// Applies --theory, --strains, --minimizer, --quadrature, --divisions to a scene. Names of the
// flags that were given go to *overridden. False and *error ("--FLAG: found ...; allowed ...").
bool ApplyFlags(Scene* scene, std::vector<std::string>* overridden, std::string* error);

// Options of --threads, --time_limit, --sparse_backend, --gradient_tolerance, --max_iterations.
bool SolverOptionsFromFlags(SolverOptions* options, std::string* error);

// The first SIGINT or SIGTERM sets the flag returned, which SolverOptions::stop takes; the second
// one ends the process.
const std::atomic<bool>* StopOnSignal();

}  // namespace darboux

#endif  // DARBOUX_TOOLS_SOLVER_FLAGS_H_
