#ifndef DARBOUX_GEOMETRY_RANDOM_STREAM_H_
#define DARBOUX_GEOMETRY_RANDOM_STREAM_H_

#include <Eigen/Core>
#include <cstdint>

namespace darboux {

// Random numbers that are the same on every machine: <random>'s distributions differ between
// libraries and log, sin and cos in the last digit, so that these are our own, made of the
// operations that IEEE 754 rounds in one way only (and built without fused ones).
//
// Every thing that needs randomness has a stream of its own, named by its purpose and its number,
// so that no draw depends on how many others there were before, or in which order. SplitMix64:
// G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators" (2014).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index);

  std::uint64_t Bits();
  double Uniform();             // in [0, 1), all multiples of 2^-53
  double Normal();              // mean 0, variance 1; G. Marsaglia's polar method
  Eigen::Vector3d Direction();  // uniform on the unit sphere
  Eigen::Vector3d InBall();     // uniform in the unit ball

 private:
  std::uint64_t state_;
};

// To 2e-16, relative, for normal x > 0.
double PortableLog(double x);
// Of an angle in turns, to 2e-16.
void PortableSinCos(double turns, double* sine, double* cosine);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_RANDOM_STREAM_H_
