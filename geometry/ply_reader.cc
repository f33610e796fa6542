#include "geometry/ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace darboux {
namespace {

enum class Type {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble
};

struct TypeName {
  const char* name;
  Type type;
};
constexpr std::array<TypeName, 18> kTypes = {{{"char", Type::kInt8},
                                              {"int8", Type::kInt8},
                                              {"uchar", Type::kUint8},
                                              {"uint8", Type::kUint8},
                                              {"short", Type::kInt16},
                                              {"int16", Type::kInt16},
                                              {"ushort", Type::kUint16},
                                              {"uint16", Type::kUint16},
                                              {"int", Type::kInt32},
                                              {"int32", Type::kInt32},
                                              {"uint", Type::kUint32},
                                              {"uint32", Type::kUint32},
                                              {"float", Type::kFloat},
                                              {"float32", Type::kFloat},
                                              {"double", Type::kDouble},
                                              {"float64", Type::kDouble},
                                              {"int64", Type::kInt64},
                                              {"uint64", Type::kUint64}}};

std::size_t Size(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kInt32:
    case Type::kUint32:
    case Type::kFloat:
      return 4;
    case Type::kInt64:
    case Type::kUint64:
    case Type::kDouble:
      return 8;
  }
  return 1;
}

template <typename T>
double Load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

// `bytes` in the order of this machine. All integers that can count something are exact.
double Load(Type type, const unsigned char* bytes) {
  switch (type) {
    case Type::kInt8:
      return Load<std::int8_t>(bytes);
    case Type::kUint8:
      return Load<std::uint8_t>(bytes);
    case Type::kInt16:
      return Load<std::int16_t>(bytes);
    case Type::kUint16:
      return Load<std::uint16_t>(bytes);
    case Type::kInt32:
      return Load<std::int32_t>(bytes);
    case Type::kUint32:
      return Load<std::uint32_t>(bytes);
    case Type::kInt64:
      return Load<std::int64_t>(bytes);
    case Type::kUint64:
      return Load<std::uint64_t>(bytes);
    case Type::kFloat:
      return Load<float>(bytes);
    case Type::kDouble:
      return Load<double>(bytes);
  }
  return 0.0;
}

bool IsLittleEndianMachine() {
  const std::uint16_t one = 1;
  unsigned char first = 0;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

struct Property {
  std::string name;
  Type type = Type::kFloat;
  bool is_list = false;
  Type count_type = Type::kUint8;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::size_t line = 0;  // In the header.
  std::vector<Property> properties;
};

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

enum class Format { kNone, kAscii, kLittleEndian, kBigEndian };

class PlyReader {
 public:
  PlyReader(std::string_view contents, MeshBuilder* builder)
      : contents_(contents), lines_(contents), builder_(*builder) {}

  bool Read() {
    if (!ReadHeader() || !FindMesh()) return false;
    for (const Element& element : elements_) {
      if (element.properties.empty()) continue;  // However many: nothing stands for them.
      if (!ReadElements(element)) return false;
    }
    return CheckEnd();
  }

  std::size_t place() const { return format_ == Format::kAscii ? lines_.number() : position_; }

 private:
  bool FailInHeader(const std::string& what) { return builder_.FailAtLine(lines_.number(), what); }
  bool ReadHeader();
  bool ReadHeaderLine();
  bool ParseType(std::string_view word, Type* type);
  bool FindMesh();
  bool ReadElements(const Element& element);
  // One value of element number i; `words` of its line in a text.
  bool ReadValue(const Element& element, std::size_t i, Type type, double* value);
  bool ReadListLength(const Element& element, std::size_t i, const Property& list, std::size_t* n);
  bool BeginElement(const Element& element, std::size_t i);
  bool EndElement(const Element& element, std::size_t i);
  bool FailAtEnd(const Element& element, std::size_t i);
  bool Fail(const std::string& what) {
    return format_ == Format::kAscii ? FailInHeader(what) : builder_.FailAtByte(position_, what);
  }
  bool CheckEnd();
  std::size_t bytes_left() const {
    return contents_.size() - (format_ == Format::kAscii ? lines_.position() : position_);
  }

  std::string_view contents_;
  LineReader lines_;
  MeshBuilder& builder_;
  std::vector<std::string_view> words_;
  std::size_t next_word_ = 0;
  std::size_t position_ = 0;  // In a binary file.
  Format format_ = Format::kNone;
  bool swaps_bytes_ = false;
  std::vector<Element> elements_;
  const Element* vertex_ = nullptr;
  const Element* face_ = nullptr;
  // Of a vertex, by property and in this order: x y z nx ny nz ux uy uz; kNone: not there.
  std::array<std::size_t, 9> values_{};
  bool has_normals_ = false;
  bool has_displacements_ = false;
  std::size_t corners_ = 0;  // Among the properties of a face.
};

bool PlyReader::ReadHeader() {
  if (!lines_.Next() || (lines_.Split(0, &words_), words_.size() != 1 || words_[0] != "ply")) {
    return builder_.FailAtLine(
        1, (words_.empty() ? "no text" : Quoted(words_[0])) + "; allowed 'ply' on the first line");
  }
  while (lines_.Next()) {
    lines_.Split(0, &words_);
    if (words_.empty()) continue;
    if (words_[0] == "end_header") {
      if (format_ == Format::kNone) {
        return FailInHeader(
            "'end_header' without a format; allowed format ascii | "
            "binary_little_endian | binary_big_endian before it");
      }
      position_ = lines_.position();
      swaps_bytes_ = (format_ == Format::kLittleEndian) != IsLittleEndianMachine();
      if (format_ != Format::kAscii) builder_.set_binary();
      return true;
    }
    if (!ReadHeaderLine()) return false;
  }
  return FailInHeader("the end of the file in the header; allowed 'end_header' first");
}

bool PlyReader::ReadHeaderLine() {
  const std::string_view key = words_[0];
  if (key == "comment" || key == "obj_info") return true;
  if (key == "format") {
    if (format_ != Format::kNone) return FailInHeader("a second 'format'; allowed one");
    const std::string_view name = words_.size() > 1 ? words_[1] : std::string_view();
    if (name == "ascii") {
      format_ = Format::kAscii;
    } else if (name == "binary_little_endian") {
      format_ = Format::kLittleEndian;
    } else if (name == "binary_big_endian") {
      format_ = Format::kBigEndian;
    } else {
      return FailInHeader(FoundInsteadOf(
          "the format", name, {"ascii", "binary_little_endian", "binary_big_endian"}));
    }
    if (words_.size() != 3 || words_[2] != "1.0") {
      return FailInHeader("the version " + Quoted(words_.size() > 2 ? words_[2] : "") +
                          "; allowed 1.0");
    }
    return true;
  }
  if (key == "element") {
    Element element;
    std::int64_t count = -1;
    if (words_.size() != 3 || !ParseInteger(words_[2], &count) || count < 0) {
      return FailInHeader("an element without a count; allowed element NAME COUNT");
    }
    element.name = std::string(words_[1]);
    element.count = static_cast<std::size_t>(count);
    element.line = lines_.number();
    for (const Element& other : elements_) {
      if (other.name == element.name) {
        return FailInHeader("a second element " + Quoted(element.name) + "; allowed one");
      }
    }
    elements_.push_back(element);
    return true;
  }
  if (key != "property") {
    return FailInHeader(
        FoundInsteadOf("the keyword",
                       key,
                       {"format", "comment", "obj_info", "element", "property", "end_header"}));
  }
  if (elements_.empty()) {
    return FailInHeader("a property before the first element; allowed after an element");
  }
  Property property;
  property.is_list = words_.size() > 1 && words_[1] == "list";
  if (words_.size() != (property.is_list ? 5u : 3u)) {
    return FailInHeader("a property of " + std::to_string(words_.size()) +
                        " words; allowed property TYPE NAME | property list TYPE TYPE NAME");
  }
  if (property.is_list) {
    if (!ParseType(words_[2], &property.count_type)) return false;
    if (property.count_type == Type::kFloat || property.count_type == Type::kDouble) {
      return FailInHeader("a list counted by " + Quoted(words_[2]) + "; allowed an integer type");
    }
  }
  if (!ParseType(words_[words_.size() - 2], &property.type)) return false;
  property.name = std::string(words_.back());
  for (const Property& other : elements_.back().properties) {
    if (other.name == property.name) {
      return FailInHeader("a second property " + Quoted(property.name) + " of the element " +
                          Quoted(elements_.back().name) + "; allowed one");
    }
  }
  elements_.back().properties.push_back(property);
  return true;
}

bool PlyReader::ParseType(std::string_view word, Type* type) {
  std::vector<std::string> names;
  for (const TypeName& known : kTypes) {
    if (word == known.name) {
      *type = known.type;
      return true;
    }
    names.push_back(known.name);
  }
  return FailInHeader(FoundInsteadOf("the type", word, names));
}

bool PlyReader::FindMesh() {
  for (const Element& element : elements_) {
    if (element.name == "vertex") vertex_ = &element;
    if (element.name == "face") face_ = &element;
  }
  if (vertex_ == nullptr) return FailInHeader("no element 'vertex' in the header; allowed one");
  static const std::array<const char*, 9> kNames = {
      "x", "y", "z", "nx", "ny", "nz", "ux", "uy", "uz"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const auto found = std::find_if(
        vertex_->properties.begin(), vertex_->properties.end(), [&](const Property& p) {
          return p.name == kNames[k] && !p.is_list;
        });
    const bool is_there = found != vertex_->properties.end();
    if (!is_there && k < 3) {
      return builder_.FailAtLine(
          vertex_->line,
          "vertices without a number " + Quoted(kNames[k]) + "; allowed with x, y and z");
    }
    values_[k] = is_there ? static_cast<std::size_t>(found - vertex_->properties.begin()) : kNone;
  }
  has_normals_ = values_[3] != kNone && values_[4] != kNone && values_[5] != kNone;
  has_displacements_ = values_[6] != kNone && values_[7] != kNone;
  if (face_ == nullptr) return true;
  const auto found =
      std::find_if(face_->properties.begin(), face_->properties.end(), [](const Property& p) {
        return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
      });
  if (found == face_->properties.end()) {
    return builder_.FailAtLine(
        face_->line, "faces without corners; allowed with a list vertex_indices or vertex_index");
  }
  corners_ = static_cast<std::size_t>(found - face_->properties.begin());
  return true;
}

bool PlyReader::FailAtEnd(const Element& element, std::size_t i) {
  if (format_ != Format::kAscii) position_ = contents_.size();
  return Fail("the end of the file in place of " + element.name + " " + std::to_string(i) +
              "; allowed " + element.name + " 0 to " + std::to_string(element.count - 1) +
              " as line " + std::to_string(element.line) + " of the header says");
}

bool PlyReader::BeginElement(const Element& element, std::size_t i) {
  if (format_ != Format::kAscii) return true;
  next_word_ = 0;
  do {
    if (!lines_.Next()) return FailAtEnd(element, i);
    lines_.Split(0, &words_);
  } while (words_.empty());
  return true;
}

bool PlyReader::EndElement(const Element& element, std::size_t i) {
  if (format_ != Format::kAscii || next_word_ == words_.size()) return true;
  return Fail(std::to_string(words_.size()) + " values of " + element.name + " " +
              std::to_string(i) + "; allowed " + std::to_string(next_word_));
}

bool PlyReader::ReadValue(const Element& element, std::size_t i, Type type, double* value) {
  if (format_ == Format::kAscii) {
    if (next_word_ >= words_.size()) {
      return Fail(std::to_string(words_.size()) + " values of " + element.name + " " +
                  std::to_string(i) + "; allowed one for each property");
    }
    const std::string_view word = words_[next_word_++];
    return ParseNumber(word, value) || Fail(Quoted(word) + " in " + element.name + " " +
                                            std::to_string(i) + "; allowed a number");
  }
  const std::size_t size = Size(type);
  if (bytes_left() < size) return FailAtEnd(element, i);
  std::array<unsigned char, 8> bytes{};
  std::memcpy(bytes.data(), contents_.data() + position_, size);
  if (swaps_bytes_) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  *value = Load(type, bytes.data());
  position_ += size;
  return true;
}

bool PlyReader::ReadListLength(const Element& element,
                               std::size_t i,
                               const Property& list,
                               std::size_t* n) {
  double length = 0.0;
  if (!ReadValue(element, i, list.count_type, &length)) return false;
  if (!(length >= 0.0) || length != std::floor(length)) {
    return Fail("a list " + Quoted(list.name) + " of negative or broken length in " + element.name +
                " " + std::to_string(i) + "; allowed a whole number");
  }
  const bool is_ascii = format_ == Format::kAscii;
  const std::size_t available =
      is_ascii ? words_.size() - next_word_ : bytes_left() / Size(list.type);
  if (length > static_cast<double>(available)) {
    return Fail("a list " + Quoted(list.name) + " longer than the " +
                (is_ascii ? "line" : "rest of the file") + " in " + element.name + " " +
                std::to_string(i) + "; allowed at most " + std::to_string(available) + " values");
  }
  *n = static_cast<std::size_t>(length);
  return true;
}

bool PlyReader::ReadElements(const Element& element) {
  const bool is_vertex = &element == vertex_;
  const bool is_face = &element == face_;
  std::size_t bytes = 0;  // Of each element at least.
  for (const Property& property : element.properties) {
    bytes += format_ == Format::kAscii
                 ? 1
                 : Size(property.is_list ? property.count_type : property.type);
  }
  // Before anything is allocated or counted through.
  if (element.count > 0 && bytes_left() / bytes < element.count) {
    if (format_ != Format::kAscii) return FailAtEnd(element, bytes_left() / bytes);
    return builder_.FailAtLine(element.line,
                               std::to_string(element.count) + " elements " + Quoted(element.name) +
                                   ", more than the file has room for; allowed as many as follow");
  }
  for (std::size_t i = 0; i < element.count; ++i) {
    const std::size_t first_byte = position_;
    if (!BeginElement(element, i)) return false;
    if (is_face) builder_.BeginFace(format_ == Format::kAscii ? lines_.number() : first_byte);
    std::array<double, 9> values{};
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      double value = 0.0;
      if (!property.is_list) {
        if (!ReadValue(element, i, property.type, &value)) return false;
        if (!is_vertex) continue;
        for (std::size_t k = 0; k < values.size(); ++k) {
          if (p == values_[k]) values[k] = value;
        }
        continue;
      }
      std::size_t n = 0;
      if (!ReadListLength(element, i, property, &n)) return false;
      for (std::size_t k = 0; k < n; ++k) {
        if (!ReadValue(element, i, property.type, &value)) return false;
        if (!is_face || p != corners_) continue;
        if (value != std::floor(value) || !(std::abs(value) < 1e15)) {
          return Fail("a corner of face " + std::to_string(i) +
                      " that is no whole number; allowed the number of a vertex");
        }
        builder_.AddCorner(static_cast<std::int64_t>(value));
      }
    }
    if (!EndElement(element, i)) return false;
    if (!is_vertex) continue;
    builder_.AddVertex({values[0], values[1], values[2]});
    if (has_normals_) builder_.AddNormal({values[3], values[4], values[5]});
    if (has_displacements_) builder_.AddDisplacement({values[6], values[7], values[8]});
  }
  return true;
}

bool PlyReader::CheckEnd() {
  if (format_ == Format::kAscii) {
    while (lines_.Next()) {
      lines_.Split(0, &words_);
      if (words_.empty()) continue;
      return Fail(Quoted(words_[0]) +
                  " after the last element; allowed the end of the file, as the "
                  "header counts no more");
    }
    return true;
  }
  // Padding is no data.
  const std::string_view rest = contents_.substr(position_);
  if (rest.find_first_not_of(std::string_view("\0\r\n \t", 5)) == std::string_view::npos)
    return true;
  return Fail(std::to_string(rest.size()) +
              " bytes after the last element; allowed the end of the "
              "file, as the header counts no more");
}

}  // namespace

bool ReadPly(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  PlyReader reader(contents, builder);
  if (!reader.Read()) return false;
  *end = reader.place();
  return true;
}

}  // namespace darboux
