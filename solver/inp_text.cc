#include "solver/inp_text.h"

#include <cstdio>

namespace darboux {

std::string InpNumber(double value) {
  char text[40];
  int digits = 15;
  do {
    std::snprintf(text, sizeof(text), "%.*g", digits, value);
  } while (std::string(text).size() > 20 && --digits > 1);
  return text;
}

std::string InpTriple(const Eigen::Vector3d& x) {
  return InpNumber(x.x()) + ", " + InpNumber(x.y()) + ", " + InpNumber(x.z());
}

std::string InpList(const std::vector<int>& numbers) {
  std::string text;
  for (size_t i = 0; i < numbers.size(); ++i) {
    text += std::to_string(numbers[i]);
    text += i + 1 == numbers.size() ? "\n" : i % 16 == 15 ? ",\n" : ", ";
  }
  return text;
}

std::string InpSet(const std::string& kind,
                   const std::string& name,
                   const std::vector<int>& numbers) {
  return "*" + kind + ", " + kind + "=" + name + "\n" + InpList(numbers);
}

std::string InpDofText(const InpDof& dof) {
  const std::string number = std::to_string(dof.dof);
  return std::to_string(dof.node) + ", " + number + ", " + number + "\n";
}

std::string InpEquation(const std::vector<std::pair<InpDof, double>>& terms) {
  std::string text = std::to_string(terms.size()) + "\n";
  for (size_t i = 0; i < terms.size(); ++i) {
    text += std::to_string(terms[i].first.node) + ", " + std::to_string(terms[i].first.dof) + ", " +
            InpNumber(terms[i].second);
    text += i + 1 == terms.size() ? "\n" : i % 4 == 3 ? ",\n" : ", ";
  }
  return text;
}

std::string InpHeader(const std::string& name,
                      const InpMesh& mesh,
                      const std::vector<std::string>& remarks) {
  std::string text;
  const auto add = [&text](const std::string& line) {
    // Readers of decks cut long lines.
    constexpr size_t kWidth = 96;
    for (size_t begin = 0; begin < line.size();) {
      size_t end = line.size();
      if (end - begin > kWidth) {
        end = line.rfind(' ', begin + kWidth);
        if (end == std::string::npos || end <= begin) end = begin + kWidth;
      }
      text += "** " + line.substr(begin, end - begin) + "\n";
      begin = end < line.size() && line[end] == ' ' ? end + 1 : end;
    }
  };
  add(name + ", written by Darboux");
  add("CalculiX: ccx NAME, without .inp. Units are those of the scene.");
  add("Elements: " + std::string(ToString(mesh.element())) + ", nodes on the " +
      (mesh.surface().is_parametric() ? "surface itself" : "limit surface") +
      (mesh.is_solid() ? " and half the thickness off it." : "."));
  add("Abaqus has these keywords as well, but for: " +
      std::string(mesh.element() == InpElement::kS6 ? "S6 is STRI65; " : "") +
      (mesh.is_solid() ? "" : "faces S1, S2 of shells are SNEG, SPOS; ") +
      "TOTALS=ONLY is TOTALS=YES; *FRICTION has the coefficient alone. Tried in CalculiX 2.20 "
      "only.");
  if (!remarks.empty()) {
    text += "**\n** Otherwise than in the scene:\n";
    for (const std::string& remark : remarks) add("- " + remark);
  }
  return text + "**\n*HEADING\n" + name.substr(0, 80) + "\n";
}

}  // namespace darboux
