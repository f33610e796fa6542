#ifndef DARBOUX_SOLVER_NPZ_WRITER_H_
#define DARBOUX_SOLVER_NPZ_WRITER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace darboux {

// NumPy's .npz: a zip archive of arrays in the .npy format, version 1.0 (NumPy Enhancement Proposal
// 1), each stored as it is. Numbers are little-endian whatever the machine, arrays in C order.
// numpy.load reads it; so does whatever opens zip archives. The same arrays give the same bytes.
class NpzWriter {
 public:
  // `name` without .npy, used once; the shape's product is the number of values.
  void Add(const std::string& name,
           const std::vector<std::size_t>& shape,
           const std::vector<double>& values);
  void Add(const std::string& name,
           const std::vector<std::size_t>& shape,
           const std::vector<std::int32_t>& values);

  // The archive. False and *error where it is larger than 4 GiB, which the plain format cannot say.
  bool Finish(std::string* archive, std::string* error);

 private:
  void AddEntry(const std::string& name, const std::string& contents);

  std::string data_, directory_;
  std::size_t num_entries_ = 0;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_NPZ_WRITER_H_
