#include "solver/npz_writer.h"

#include <glog/logging.h>

#include <array>
#include <cstring>

namespace darboux {
namespace {

template <typename Int>
void AppendLittle(Int value, size_t num_bytes, std::string* bytes) {
  for (size_t i = 0; i < num_bytes; ++i) {
    bytes->push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff));
  }
}

// The checksum of zip archives: polynomial 0xEDB88320 (ISO 3309), reflected.
std::uint32_t Crc32(const std::string& bytes) {
  static const std::array<std::uint32_t, 256>& table = *[] {
    auto* const entries = new std::array<std::uint32_t, 256>;
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = c & 1 ? 0xEDB88320u ^ c >> 1 : c >> 1;
      (*entries)[i] = c;
    }
    return entries;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes)
    crc = table[(crc ^ static_cast<unsigned char>(byte)) & 0xff] ^ crc >> 8;
  return crc ^ 0xffffffffu;
}

// Magic, version, length and the dictionary, padded so that what follows is aligned to 64 bytes.
std::string NpyHeader(const std::string& type, const std::vector<size_t>& shape, size_t count) {
  std::string tuple;
  size_t product = 1;
  for (const size_t n : shape) {
    tuple += std::to_string(n) + (shape.size() == 1 ? "," : ", ");
    product *= n;
  }
  CHECK_EQ(product, count);
  if (shape.size() > 1) tuple.resize(tuple.size() - 2);
  std::string text =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + tuple + "), }";
  constexpr size_t kBefore = 10;
  text.append(63 - (kBefore + text.size()) % 64, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  AppendLittle(text.size(), 2, &header);
  return header + text;
}

// Of 1 January 1980, the first that the format has: files do not depend on when they were written.
constexpr std::uint32_t kDate = (0u << 25 | 1u << 21 | 1u << 16);
constexpr int kVersion = 20;  // 2.0, all that stored entries need
constexpr size_t kLimit = 0xffffffffu;

}  // namespace

void NpzWriter::Add(const std::string& name,
                    const std::vector<size_t>& shape,
                    const std::vector<double>& values) {
  std::string contents = NpyHeader("<f8", shape, values.size());
  contents.reserve(contents.size() + 8 * values.size());
  for (const double value : values) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    AppendLittle(bits, 8, &contents);
  }
  AddEntry(name, contents);
}

void NpzWriter::Add(const std::string& name,
                    const std::vector<size_t>& shape,
                    const std::vector<std::int32_t>& values) {
  std::string contents = NpyHeader("<i4", shape, values.size());
  for (const std::int32_t value : values) {
    AppendLittle(static_cast<std::uint32_t>(value), 4, &contents);
  }
  AddEntry(name, contents);
}

void NpzWriter::AddEntry(const std::string& name, const std::string& contents) {
  const std::string file = name + ".npy";
  const size_t offset = data_.size();
  // What both the entry and the directory have: flags, method (stored), date, checksum, sizes.
  std::string common;
  AppendLittle(0, 2, &common);
  AppendLittle(0, 2, &common);
  AppendLittle(kDate, 4, &common);
  AppendLittle(Crc32(contents), 4, &common);
  AppendLittle(contents.size(), 4, &common);
  AppendLittle(contents.size(), 4, &common);
  AppendLittle(file.size(), 2, &common);
  AppendLittle(0, 2, &common);  // no extra field

  data_ += "PK\x03\x04";
  AppendLittle(kVersion, 2, &data_);
  data_ += common + file + contents;

  directory_ += "PK\x01\x02";
  AppendLittle(kVersion, 2, &directory_);
  AppendLittle(kVersion, 2, &directory_);
  directory_ += common;
  AppendLittle(0, 2, &directory_);  // comment
  AppendLittle(0, 2, &directory_);  // disk
  AppendLittle(0, 2, &directory_);  // internal attributes
  AppendLittle(0, 4, &directory_);  // external attributes
  AppendLittle(offset, 4, &directory_);
  directory_ += file;
  ++num_entries_;
}

bool NpzWriter::Finish(std::string* archive, std::string* error) {
  if (data_.size() + directory_.size() > kLimit || num_entries_ > 0xffff) {
    *error = "fields.npz would be larger than 4 GiB; fewer steps or a coarser mesh are not";
    return false;
  }
  *archive = data_ + directory_;
  *archive += "PK\x05\x06";
  AppendLittle(0, 4, archive);  // disks
  AppendLittle(num_entries_, 2, archive);
  AppendLittle(num_entries_, 2, archive);
  AppendLittle(directory_.size(), 4, archive);
  AppendLittle(data_.size(), 4, archive);
  AppendLittle(0, 2, archive);  // comment
  return true;
}

}  // namespace darboux
