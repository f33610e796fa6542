// Whether AddressSanitizer watches this build: GCC says so with a macro, clang with a feature.
#ifndef DARBOUX_TESTS_SANITIZER_UTIL_H_
#define DARBOUX_TESTS_SANITIZER_UTIL_H_

#if defined(__SANITIZE_ADDRESS__)
#define DARBOUX_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define DARBOUX_ADDRESS_SANITIZER 1
#endif
#endif

namespace darboux {

#if defined(DARBOUX_ADDRESS_SANITIZER)
constexpr bool kAddressSanitizer = true;
#else
constexpr bool kAddressSanitizer = false;
#endif

// What sanitizers and builds without optimisation are allowed on top of a time.
#if defined(DARBOUX_ADDRESS_SANITIZER) || !defined(__OPTIMIZE__)
constexpr double kSlowdown = 20.0;
#else
constexpr double kSlowdown = 1.0;
#endif

}  // namespace darboux

#endif  // DARBOUX_TESTS_SANITIZER_UTIL_H_
