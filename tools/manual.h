#ifndef DARBOUX_TOOLS_MANUAL_H_
#define DARBOUX_TOOLS_MANUAL_H_

#include <string>
#include <vector>

namespace darboux {

// The parts of a manual in their order, as text for a terminal and as source of a page for man(1).
// Texts are ASCII; line breaks in them count as spaces, empty lines part paragraphs.
class Manual {
 public:
  void Section(const std::string& title);
  void Subsection(const std::string& title);
  void Name(const std::string& name, const std::string& purpose);
  void Synopsis(const std::string& name, const std::string& usage);
  void Paragraph(const std::string& text);  // or several; none where it is empty
  // A term in bold letters, "=" and its value; below, indented, what type it has, and a text.
  void Item(const std::string& term,
            const std::string& value,
            const std::string& type,
            const std::string& text);
  // Below a text a line that may be copied into a shell; long ones go on after a backslash.
  void Command(const std::string& command, const std::string& text);

  std::string Text(bool bold) const;
  std::string Roff(const std::string& name, const std::string& version) const;

 private:
  enum class Kind { kSection, kSubsection, kName, kSynopsis, kParagraph, kItem, kCommand };
  struct Part {
    Kind kind;
    std::string head, value, type, text;
  };
  std::vector<Part> parts_;
};

}  // namespace darboux

#endif  // DARBOUX_TOOLS_MANUAL_H_
