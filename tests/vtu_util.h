#ifndef DARBOUX_TESTS_VTU_UTIL_H_
#define DARBOUX_TESTS_VTU_UTIL_H_

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/file_util.h"

// Reads the .vtu files that the results have.

namespace darboux {

inline std::string DecodeBase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  EXPECT_EQ(text.size() % 4, 0u);
  std::string bytes;
  for (size_t i = 0; i + 4 <= text.size(); i += 4) {
    std::uint32_t group = 0;
    int padding = 0;
    for (size_t k = 0; k < 4; ++k) {
      const size_t digit = digits.find(text[i + k]);
      if (text[i + k] == '=') ++padding;
      EXPECT_TRUE(digit != std::string::npos || text[i + k] == '=');
      group = group << 6 | static_cast<std::uint32_t>(digit == std::string::npos ? 0 : digit);
    }
    for (int k = 0; k < 3 - padding; ++k) bytes += static_cast<char>(group >> (16 - 8 * k) & 255);
  }
  return bytes;
}

template <typename T>
T ValueAt(const std::string& bytes, size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

struct XmlElement {
  std::string path;  // VTKFile/UnstructuredGrid/...
  std::map<std::string, std::string> attributes;
  std::string text;  // up to the next tag
};

// Elements in document order; fails the test where tags are not balanced.
inline std::vector<XmlElement> ScanXml(const std::string& xml) {
  std::vector<XmlElement> elements;
  std::vector<std::string> open;
  for (size_t begin = xml.find('<'); begin != std::string::npos; begin = xml.find('<', begin + 1)) {
    const size_t end = xml.find('>', begin);
    if (end == std::string::npos) {
      ADD_FAILURE() << "tag without end";
      break;
    }
    std::string tag = xml.substr(begin + 1, end - begin - 1);
    if (tag[0] == '?') continue;
    if (tag[0] == '/') {
      EXPECT_FALSE(open.empty());
      if (open.empty()) break;
      EXPECT_EQ(open.back(), tag.substr(1));
      open.pop_back();
      continue;
    }
    const bool closed = tag.back() == '/';
    if (closed) tag.pop_back();
    XmlElement element;
    const std::string name = tag.substr(0, tag.find(' '));
    for (const std::string& parent : open) element.path += parent + "/";
    element.path += name;
    for (size_t at = name.size(); (at = tag.find('=', at)) != std::string::npos;) {
      const size_t start = tag.rfind(' ', at) + 1, quote = tag.find('"', at + 2);
      element.attributes[tag.substr(start, at - start)] = tag.substr(at + 2, quote - at - 2);
      at = quote;
    }
    element.text = xml.substr(end + 1, xml.find('<', end) - end - 1);
    elements.push_back(std::move(element));
    if (!closed) open.push_back(name);
  }
  EXPECT_TRUE(open.empty());
  return elements;
}

struct Vtu {
  size_t num_points = 0, num_cells = 0;
  std::map<std::string, std::vector<double>> arrays;  // Points, connectivity, ..., point data
  std::map<std::string, int> components;
};

// Reads a .vtu file and checks what VTK requires of it.
inline Vtu ReadVtu(const std::filesystem::path& path) {
  Vtu vtu;
  for (const XmlElement& element : ScanXml(ReadFile(path))) {
    const auto attribute = [&](const std::string& name) {
      const auto it = element.attributes.find(name);
      return it == element.attributes.end() ? std::string() : it->second;
    };
    if (element.path == "VTKFile") {
      EXPECT_EQ(attribute("type"), "UnstructuredGrid");
      EXPECT_EQ(attribute("header_type"), "UInt64");
    }
    if (element.path == "VTKFile/UnstructuredGrid/Piece") {
      vtu.num_points = std::stoul(attribute("NumberOfPoints"));
      vtu.num_cells = std::stoul(attribute("NumberOfCells"));
    }
    if (element.path.size() < 9 || element.path.substr(element.path.size() - 9) != "DataArray") {
      continue;
    }
    EXPECT_EQ(attribute("format"), "binary");
    const std::string bytes = DecodeBase64(element.text);
    EXPECT_EQ(ValueAt<std::uint64_t>(bytes, 0), bytes.size() - 8);
    const std::string type = attribute("type");
    const size_t size = type == "Float64" ? 8 : type == "Int32" ? 4 : 1;
    std::vector<double> values;
    for (size_t at = 8; at < bytes.size(); at += size) {
      values.push_back(type == "Float64" ? ValueAt<double>(bytes, at)
                       : type == "Int32" ? ValueAt<std::int32_t>(bytes, at)
                                         : ValueAt<std::uint8_t>(bytes, at));
    }
    for (const double value : values) EXPECT_TRUE(std::isfinite(value)) << attribute("Name");
    const std::string components = attribute("NumberOfComponents");
    vtu.components[attribute("Name")] = components.empty() ? 1 : std::stoi(components);
    vtu.arrays[attribute("Name")] = std::move(values);
  }
  const auto& connectivity = vtu.arrays["connectivity"];
  EXPECT_EQ(connectivity.size(), 3 * vtu.num_cells);
  for (const double index : connectivity) {
    EXPECT_GE(index, 0.0);
    EXPECT_LT(index, static_cast<double>(vtu.num_points));
  }
  EXPECT_EQ(vtu.arrays["offsets"].size(), vtu.num_cells);
  for (size_t i = 0; i < vtu.num_cells; ++i) EXPECT_EQ(vtu.arrays["offsets"][i], 3.0 * (i + 1));
  EXPECT_EQ(vtu.arrays["types"], std::vector<double>(vtu.num_cells, 5.0));
  for (const auto& [name, values] : vtu.arrays) {
    if (name == "connectivity" || name == "offsets" || name == "types" || name == "TimeValue") {
      continue;
    }
    EXPECT_EQ(values.size(), vtu.num_points * vtu.components[name]) << name;
  }
  return vtu;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_VTU_UTIL_H_
