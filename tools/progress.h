#ifndef DARBOUX_TOOLS_PROGRESS_H_
#define DARBOUX_TOOLS_PROGRESS_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/shell_solver.h"

namespace darboux {

// What a tool says while it works, on stderr, of which a process has one.
//
// As text: a line for each load step, level, run and weight, and on a terminal below them a live
// line with step, load factor, iteration, gradient, energy and the time left. Elsewhere the live
// line appears as a line of its own every half a minute.
//
// --log=json: every line of stderr is one JSON object, with "event", "t" (seconds since the tool
// began) and what the event has; numbers that are not finite are null. Events and their keys are
// listed in README.md. Warnings and errors of the libraries below come as events too.
//
// --quiet: errors alone, in either form.
namespace progress {

using Json = nlohmann::ordered_json;

// Whether --log=json stands in a command line that is still to be read: mistakes in it are events.
bool AsksForJson(const std::vector<std::string>& words);

// From here on the flags decide. `tool`: outlives the process, as literals do.
void Start(const char* tool, const char* version, const std::vector<std::string>& words);

bool IsJson();

// A line for good: `text` without the tool's name and newline, or the event with its fields.
void Say(const char* event, const Json& fields, const std::string& text);
// Text on the live line until the next line, at most ten times a second.
void Live(const std::string& text);
// "TOOL: message"; also where Start has not been called.
void Error(const char* tool, const std::string& message, bool json);
void Error(const std::string& message);
// The last event. Takes the live line away. Returns the status.
int Done(int exit_status);

// Load steps and iterations of every solve with these options. whole_work: one solve is all the
// tool's work, so that the time left of it is the tool's. `prefix` names the solve on the live
// line.
void Watch(bool whole_work, const std::string& prefix, SolverOptions* options);

// "3 s", "2 min 5 s", "1 h 12 min".
std::string FormatDuration(double seconds);

}  // namespace progress
}  // namespace darboux

#endif  // DARBOUX_TOOLS_PROGRESS_H_
