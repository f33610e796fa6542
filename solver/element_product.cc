#include "solver/element_product.h"

#include <algorithm>
#include <cstring>

namespace darboux {
namespace {

constexpr int kVectors = 5;
constexpr int kInputs = 3 * kVectors;
constexpr int kLanes = 4;
constexpr int kHalf = 3 * kInputs;  // of a point and a vertex
constexpr int kPaddedHalf = (kHalf + kLanes - 1) / kLanes * kLanes;
constexpr int kPadding = kPaddedHalf - kHalf;

// Four doubles; memory need not be aligned for them.
typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));

struct Arrays {
  int num_vertices, num_points, stride;
  const double *weights, *points;
  double *half, *result;
};

// half[q][j] = sum_c w_q,jc M_q(:, c): three columns of a point's matrix for each c.
// result[j][b][a][i] = sum_q,d half[q][j][b][d][a] w_q,id, from the block of four that has i = j
// on.
inline __attribute__((always_inline)) void MultiplyArrays(const Arrays& arrays) {
  const auto [num_vertices, num_points, stride, weights, points, half, result] = arrays;
  for (int q = 0; q < num_points; ++q) {
    const double* const m = points + q * (kInputs * kInputs + kPadding);
    const double* const w = weights + q * kVectors * stride;
    for (int j = 0; j < num_vertices; ++j) {
      double* const to = half + (q * num_vertices + j) * kPaddedHalf;
      for (int r = 0; r < kPaddedHalf; r += kLanes) {
        Lanes sum = {};
        for (int c = 0; c < kVectors; ++c) {
          Lanes column;
          std::memcpy(&column, m + kHalf * c + r, sizeof column);
          sum += column * w[c * stride + j];
        }
        std::memcpy(to + r, &sum, sizeof sum);
      }
    }
  }
  for (int j = 0; j < num_vertices; ++j) {
    double* const to = result + 9 * j * stride;
    for (int i = j / kLanes * kLanes; i < stride; i += kLanes) {
      Lanes sum[9] = {};
      for (int q = 0; q < num_points; ++q) {
        const double* const from = half + (q * num_vertices + j) * kPaddedHalf;
        for (int d = 0; d < kVectors; ++d) {
          Lanes w;
          std::memcpy(&w, weights + (q * kVectors + d) * stride + i, sizeof w);
          for (int b = 0; b < 3; ++b) {
            for (int a = 0; a < 3; ++a) sum[3 * b + a] += w * from[kInputs * b + 3 * d + a];
          }
        }
      }
      for (int k = 0; k < 9; ++k) std::memcpy(to + k * stride + i, &sum[k], sizeof sum[k]);
    }
  }
}

void ForAnyProcessor(const Arrays& arrays) { MultiplyArrays(arrays); }

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void ForFmaProcessor(const Arrays& arrays) {
  MultiplyArrays(arrays);
}
#endif

using Products = void (*)(const Arrays&);

Products ForThisProcessor() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return ForFmaProcessor;
#endif
  return ForAnyProcessor;
}

}  // namespace

void ElementProduct::Begin(int num_vertices, int num_points) {
  num_vertices_ = num_vertices;
  num_points_ = num_points;
  stride_ = (num_vertices + kLanes - 1) / kLanes * kLanes;
  weights_.assign(static_cast<size_t>(num_points) * kVectors * stride_, 0.0);
  points_.assign(static_cast<size_t>(num_points) * (kInputs * kInputs + kPadding), 0.0);
  half_.resize(static_cast<size_t>(num_points) * num_vertices * kPaddedHalf);
  result_.resize(static_cast<size_t>(9) * num_vertices * stride_);
}

void ElementProduct::SetPoint(int q, const StrainPoint& point, const PointMatrix& matrix) {
  double* const w = weights_.data() + static_cast<size_t>(q) * kVectors * stride_;
  for (int i = 0; i < num_vertices_; ++i) {
    for (int c = 0; c < kVectors; ++c) w[c * stride_ + i] = point.weights(kRowD1 + c, i);
  }
  std::copy_n(matrix.data(),
              kInputs * kInputs,
              points_.data() + static_cast<size_t>(q) * (kInputs * kInputs + kPadding));
}

void ElementProduct::Multiply() {
  static const Products products = ForThisProcessor();
  products({num_vertices_,
            num_points_,
            stride_,
            weights_.data(),
            points_.data(),
            half_.data(),
            result_.data()});
}

}  // namespace darboux
