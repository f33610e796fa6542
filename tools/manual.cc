#include "tools/manual.h"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace darboux {
namespace {

constexpr size_t kColumns = 80;

// Words of a text without what is between them.
std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> Lines(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Paragraphs(const std::string& text) {
  std::vector<std::string> paragraphs;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find("\n\n", begin), text.size());
    if (end > begin) paragraphs.push_back(text.substr(begin, end - begin));
    begin = end + 2;
  }
  return paragraphs;
}

// Lines of at most kColumns, all of them indented.
std::string Wrapped(const std::string& text, size_t indent) {
  std::string lines, line;
  for (const std::string& word : Words(text)) {
    if (!line.empty() && line.size() + 1 + word.size() > kColumns) {
      lines += line + "\n";
      line.clear();
    }
    line += line.empty() ? std::string(indent, ' ') + word : " " + word;
  }
  return line.empty() ? lines : lines + line + "\n";
}

// A text in roff: words, in lines of which none is taken for a request. A hyphen that belongs to a
// flag or a command has to stay one when it is copied.
std::string Escaped(const std::string& text, bool literal) {
  std::string roff;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool starts_word = i == 0 || std::isspace(static_cast<unsigned char>(text[i - 1])) ||
                             text[i - 1] == '(' || text[i - 1] == '-';
    if (c == '\\') {
      roff += "\\e";
    } else if (c == '-' && (literal || starts_word)) {
      roff += "\\-";
    } else if ((c == '.' || c == '\'') && (i == 0 || text[i - 1] == '\n')) {
      roff += std::string("\\&") + c;
    } else if (c == '\'') {
      roff += "\\(aq";
    } else if (c == '~') {
      roff += "\\(ti";
    } else if (c == '^') {
      roff += "\\(ha";
    } else {
      roff += c;
    }
  }
  return roff;
}

std::string RoffText(const std::string& text) {
  std::string joined;
  for (const std::string& word : Words(text)) joined += (joined.empty() ? "" : " ") + word;
  return Escaped(joined, false) + "\n";
}

}  // namespace

void Manual::Section(const std::string& title) {
  parts_.push_back({Kind::kSection, title, "", "", ""});
}

void Manual::Subsection(const std::string& title) {
  parts_.push_back({Kind::kSubsection, title, "", "", ""});
}

void Manual::Name(const std::string& name, const std::string& purpose) {
  parts_.push_back({Kind::kName, name, "", "", purpose});
}

void Manual::Synopsis(const std::string& name, const std::string& usage) {
  parts_.push_back({Kind::kSynopsis, name, "", "", usage});
}

void Manual::Paragraph(const std::string& text) {
  for (const std::string& paragraph : Paragraphs(text)) {
    parts_.push_back({Kind::kParagraph, "", "", "", paragraph});
  }
}

void Manual::Item(const std::string& term,
                  const std::string& value,
                  const std::string& type,
                  const std::string& text) {
  parts_.push_back({Kind::kItem, term, value, type, text});
}

void Manual::Command(const std::string& command, const std::string& text) {
  parts_.push_back({Kind::kCommand, command, "", "", text});
}

std::string Manual::Text(bool bold) const {
  const auto strong = [bold](const std::string& text) {
    return bold ? "\033[1m" + text + "\033[0m" : text;
  };
  std::string out;
  for (size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const Kind before = i == 0 ? Kind::kSection : parts_[i - 1].kind;
    const bool follows_head = before == Kind::kSection || before == Kind::kSubsection;
    switch (part.kind) {
      case Kind::kSection:
        out += (i == 0 ? "" : "\n") + strong(part.head) + "\n";
        break;
      case Kind::kSubsection:
        out += "\n " + strong(part.head) + "\n";
        break;
      case Kind::kName:
        out += Wrapped(part.head + " - " + part.text, 2);
        break;
      case Kind::kSynopsis:
        out += "  " + strong(part.head) + " " + part.text + "\n";
        break;
      case Kind::kParagraph:
        if (before == Kind::kParagraph) out += "\n";
        out += Wrapped(part.text, 2);
        if (i + 1 < parts_.size() && parts_[i + 1].kind == Kind::kItem) out += "\n";
        break;
      case Kind::kItem: {
        // What is short stands beside its term.
        const std::string value = part.value.empty() ? "" : "=" + part.value;
        const size_t width = 2 + part.head.size() + value.size();
        if (part.type.empty() && part.head.size() < 3) {
          std::string text = Wrapped(part.text, 6);
          text.replace(2, part.head.size(), strong(part.head));
          out += text;
          break;
        }
        out += "  " + strong(part.head) + value;
        if (!part.type.empty()) {
          const std::string type = "(" + part.type + ")";
          const bool fits = width + 2 + type.size() <= kColumns;
          out += fits ? "  " + type + "\n" : "\n" + Wrapped(type, 6);
        } else {
          out += "\n";
        }
        out += Wrapped(part.text, 6);
        break;
      }
      case Kind::kCommand:
        if (!follows_head) out += "\n";
        out += Wrapped(part.text, 2);
        for (const std::string& line : Lines(part.head)) out += "      " + line + "\n";
        break;
    }
  }
  return out;
}

std::string Manual::Roff(const std::string& name, const std::string& version) const {
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  // No date: the same source gives the same page.
  std::string out = ".TH " + title + " 1 \"\" \"Darboux " + version + "\" \"Darboux\"\n";
  out += ".nh\n.ad l\n";  // Names that are copied are not hyphenated.
  for (size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const Kind before = i == 0 ? Kind::kSection : parts_[i - 1].kind;
    const bool follows_head = before == Kind::kSection || before == Kind::kSubsection;
    switch (part.kind) {
      case Kind::kSection:
        out += ".SH \"" + part.head + "\"\n";
        break;
      case Kind::kSubsection:
        out += ".SS \"" + part.head + "\"\n";
        break;
      case Kind::kName:
        out += part.head + " \\- " + RoffText(part.text);
        break;
      case Kind::kSynopsis:
        if (before == Kind::kSynopsis) out += ".br\n";
        out += "\\fB" + Escaped(part.head, true) + "\\fR " + Escaped(part.text, true) + "\n";
        break;
      case Kind::kParagraph:
        if (!follows_head) out += ".PP\n";
        out += RoffText(part.text);
        break;
      case Kind::kItem: {
        out += ".TP\n\\fB" + Escaped(part.head, true) + "\\fR";
        if (!part.value.empty()) out += "=\\fI" + Escaped(part.value, true) + "\\fR";
        if (!part.type.empty()) out += "  (" + Escaped(part.type, false) + ")";
        out += "\n" + RoffText(part.text);
        break;
      }
      case Kind::kCommand:
        if (!follows_head) out += ".PP\n";
        out += RoffText(part.text) + ".PP\n.RS 4\n.nf\n";
        for (const std::string& line : Lines(part.head)) out += Escaped(line, true) + "\n";
        out += ".fi\n.RE\n";
        break;
    }
  }
  return out;
}

}  // namespace darboux
