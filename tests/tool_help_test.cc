// The manual of every tool, as its users meet it: --help, pages for man(1), and examples that run.

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// In order, with what stands below each.
std::map<std::string, std::vector<std::string>> Sections(const std::string& help) {
  std::map<std::string, std::vector<std::string>> sections;
  std::string title;
  for (const std::string& line : Lines(help)) {
    if (!line.empty() && line[0] != ' ') {
      title = line;
    } else {
      sections[title].push_back(line);
    }
  }
  return sections;
}

// Letters and digits of a text in a row: what is left of it in any layout.
std::string Letters(const std::string& text) {
  std::string letters;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c))) letters += c;
  }
  return letters;
}

class ToolHelpTest : public FolderTest, public ::testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override { fs::create_directory_symlink(DARBOUX_DATA_DIR, folder_ / "data"); }

  // Exit status of a command of the shell, which finds the tools.
  int Run(const std::string& command) {
    return RunCommand(folder_,
                      "PATH=\"" DARBOUX_TOOLS_DIR
                      ":$PATH\" && OPENBLAS_NUM_THREADS=1 && export PATH OPENBLAS_NUM_THREADS && "
                      "{ " +
                          command + "\n}")
        .status;
  }
  std::string Stdout() const { return ReadFile(folder_ / "stdout"); }
  std::string Stderr() const { return ReadFile(folder_ / "stderr"); }
  std::string Tool() const { return GetParam(); }

  std::string Help() {
    EXPECT_EQ(Run(Tool() + " --help"), 0);
    EXPECT_THAT(Stderr(), IsEmpty());
    return Stdout();
  }

  // What --help prints on a terminal of this kind.
  std::string HelpOnTerminal(const char* terminal, const char* no_color) {
    int master = -1;
    const pid_t pid = forkpty(&master, nullptr, nullptr, nullptr);
    if (pid == 0) {
      setenv("TERM", terminal, 1);
      no_color == nullptr ? unsetenv("NO_COLOR") : setenv("NO_COLOR", no_color, 1);
      const std::string path = std::string(DARBOUX_TOOLS_DIR) + "/" + Tool();
      execl(path.c_str(), path.c_str(), "--help", nullptr);
      _exit(127);
    }
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(master, buffer, sizeof(buffer))) > 0;) text.append(buffer, n);
    int status = 0;
    EXPECT_EQ(waitpid(pid, &status, 0), pid);
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0);
    close(master);
    return text;
  }
};

TEST_P(ToolHelpTest, SaysEverythingInEightyColumns) {
  const std::string help = Help();
  for (const std::string& line : Lines(help)) {
    EXPECT_LE(line.size(), 80U) << line;
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~') << line;
  }
  EXPECT_THAT(help, StartsWith("NAME\n  " + Tool() + " - "));
  std::vector<std::string> titles = {
      "NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"};
  if (Tool() != "darboux_duck") titles.insert(titles.end(), {"ARGUMENTS", "FILES", "SIGNALS"});
  const auto sections = Sections(help);
  for (const std::string& title : titles) EXPECT_EQ(sections.count(title), 1U) << title;
  EXPECT_EQ(Run(Tool() + " -h"), 0);
  EXPECT_EQ(Stdout(), help);
}

TEST_P(ToolHelpTest, EveryFlagHasAGroupATypeAndADefault) {
  const auto sections = Sections(Help());
  int flags = 0;
  const std::vector<std::string>& lines = sections.at("OPTIONS");
  for (size_t i = 0; i < lines.size(); ++i) {
    EXPECT_NE(lines[i], " Other") << "a flag whose text is not of the form in tools/help.h";
    EXPECT_THAT(lines[i], Not(HasSubstr(" | ")));
    if (lines[i] == " General") break;
    if (lines[i].compare(0, 4, "  --") != 0 || lines[i].compare(0, 6, "  --fl") == 0) continue;
    ++flags;
    // Beside the flag, or below it in one or two lines.
    std::string type = lines[i];
    for (size_t k = i + 1; k < lines.size() && type.back() != ')'; ++k) type += lines[k];
    EXPECT_THAT(type, MatchesRegex("  --[a-z_]+(=[A-Z,]+)? +[(].+(default: |required).*[)]"));
  }
  EXPECT_GE(flags, 3);
}

TEST_P(ToolHelpTest, IsBoldOnATerminalOnly) {
  EXPECT_THAT(Help(), Not(HasSubstr("\033")));
  EXPECT_THAT(HelpOnTerminal("xterm", nullptr), HasSubstr("\033[1mEXIT STATUS\033[0m"));
  EXPECT_THAT(HelpOnTerminal("xterm", ""), HasSubstr("\033[1m"));
  EXPECT_THAT(HelpOnTerminal("xterm", "1"), Not(HasSubstr("\033")));
  EXPECT_THAT(HelpOnTerminal("dumb", nullptr), Not(HasSubstr("\033")));
}

TEST_P(ToolHelpTest, ManShowsTheSame) {
  const std::string help = Help();
  ASSERT_EQ(Run(Tool() + " --help=man > page.1"), 0);
  EXPECT_THAT(ReadFile(folder_ / "page.1"), StartsWith(".TH DARBOUX_"));
  if (Run("command -v man") != 0) GTEST_SKIP() << "no man(1) here";
  EXPECT_EQ(Run("MANWIDTH=80 LC_ALL=C man --warnings -l page.1 | cat"), 0);
  EXPECT_THAT(Stderr(), IsEmpty());
  std::string page = Stdout();
  // Header and footer.
  page.erase(0, page.find('\n'));
  page.erase(page.find_last_of('\n', page.size() - 2));
  EXPECT_EQ(Letters(page), Letters(help));
}

TEST_P(ToolHelpTest, ExamplesRun) {
  int examples = 0;
  std::string command;
  const auto sections = Sections(Help());
  for (const std::string& line : sections.at("EXAMPLES")) {
    if (line.compare(0, 6, "      ") != 0) continue;
    command += line + "\n";
    if (line.back() == '\\') continue;
    ++examples;
    EXPECT_THAT(command, HasSubstr(Tool() + " "));
    EXPECT_EQ(Run(command), 0) << command << Stderr();
    command.clear();
  }
  EXPECT_GE(examples, 2);
  EXPECT_THAT(command, IsEmpty());
}

TEST_P(ToolHelpTest, VersionNamesTheLibraries) {
  EXPECT_EQ(Run(Tool() + " --version"), 0);
  std::string libraries = "Eigen 3[.][0-9.]+, OpenSubdiv 3[.][0-9.]+";
  if (Tool() != "darboux_duck") libraries += ", Ceres 2[.][0-9.]+";
  EXPECT_THAT(Stdout(), MatchesRegex(Tool() + " [0-9.]+\n" + libraries + "\n"));
}

TEST_P(ToolHelpTest, AMisspeltFlagHasAProposal) {
  for (const char* flag : {"out", "help", "version"}) {
    EXPECT_EQ(Run(Tool() + " --" + flag + "x=1"), 2);
    EXPECT_THAT(Stderr(), HasSubstr("did you mean '--" + std::string(flag) + "'?"));
    EXPECT_THAT(Stderr(), HasSubstr("\nusage: " + Tool() + " "));
    EXPECT_THAT(Stdout(), IsEmpty());
  }
}

INSTANTIATE_TEST_SUITE_P(Tools,
                         ToolHelpTest,
                         ::testing::Values("darboux_accuracy",
                                           "darboux_calibrate",
                                           "darboux_deform",
                                           "darboux_duck",
                                           "darboux_fit",
                                           "darboux_scan"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace darboux
