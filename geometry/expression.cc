#include "geometry/expression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>
#include <type_traits>
#include <vector>

namespace darboux {
namespace {

// The twins of Taylor3's functions that <cmath> lacks; like them, they never hide a NaN.
double sign(double x) { return std::isnan(x) ? x : static_cast<double>((x > 0.0) - (x < 0.0)); }
double min(double a, double b) { return b < a || std::isnan(b) ? b : a; }
double max(double a, double b) { return b > a || std::isnan(b) ? b : a; }
double Power(double a, double b) { return Taylor3::Power(a, b); }
Taylor3 Power(const Taylor3& a, double b) { return pow(a, b); }
Taylor3 Power(const Taylor3& a, const Taylor3& b) { return pow(a, b); }

}  // namespace

int Expression::OperandCount(Op op) {
  switch (op) {
    case Op::kConstant:
    case Op::kVariable:
      return 0;
    case Op::kAdd:
    case Op::kSubtract:
    case Op::kMultiply:
    case Op::kDivide:
    case Op::kPower:
    case Op::kLess:
    case Op::kLessEqual:
    case Op::kGreater:
    case Op::kGreaterEqual:
    case Op::kEqual:
    case Op::kNotEqual:
    case Op::kAtan2:
    case Op::kMin:
    case Op::kMax:
      return 2;
    default:
      return 1;
  }
}

template <typename T>
T Expression::Run(const std::vector<Instruction>& tape, int stack_size, const T* values) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp;
  using std::log, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

  // Raw memory, since clearing so many Taylor3 costs as much as a short formula. Only a formula
  // with very many waiting operands goes to the heap.
  constexpr int kInlineSize = 16;
  alignas(T) unsigned char memory[kInlineSize * sizeof(T)];
  std::vector<T> heap;
  if (stack_size > kInlineSize) heap.resize(static_cast<size_t>(stack_size));
  T* end = stack_size > kInlineSize ? heap.data() : reinterpret_cast<T*>(memory);

  for (const Instruction& step : tape) {
    const double k = step.constant;
    switch (step.op) {
      case Op::kConstant:
        new (end++) T(k);
        continue;
      case Op::kVariable:
        new (end++) T(values[step.variable]);
        continue;
      default:
        break;
    }
    if (OperandCount(step.op) == 2) --end;
    T& a = end[-1];    // The left operand, replaced by the result.
    const T* b = end;  // The right operand, if there is one.
    switch (step.op) {
      case Op::kConstant:
      case Op::kVariable:
        break;
      case Op::kAdd:
        a += *b;
        break;
      case Op::kSubtract:
        a -= *b;
        break;
      case Op::kMultiply:
        a *= *b;
        break;
      case Op::kDivide:
        a /= *b;
        break;
      case Op::kPower:
        a = Power(a, *b);
        break;
      case Op::kAddConstant:
        a += k;
        break;
      case Op::kSubtractFromConstant:
        a = k - a;
        break;
      case Op::kMultiplyConstant:
        a *= k;
        break;
      case Op::kDivideByConstant:
        a /= k;
        break;
      case Op::kPowerConstant:
        a = Power(a, k);
        break;
      case Op::kNegate:
        a = -a;
        break;
      case Op::kLess:
        a = T(a < *b ? 1.0 : 0.0);
        break;
      case Op::kLessEqual:
        a = T(a <= *b ? 1.0 : 0.0);
        break;
      case Op::kGreater:
        a = T(a > *b ? 1.0 : 0.0);
        break;
      case Op::kGreaterEqual:
        a = T(a >= *b ? 1.0 : 0.0);
        break;
      case Op::kEqual:
        a = T(a == *b ? 1.0 : 0.0);
        break;
      case Op::kNotEqual:
        a = T(a != *b ? 1.0 : 0.0);
        break;
      case Op::kSin:
        a = sin(a);
        break;
      case Op::kCos:
        a = cos(a);
        break;
      case Op::kTan:
        a = tan(a);
        break;
      case Op::kAsin:
        a = asin(a);
        break;
      case Op::kAcos:
        a = acos(a);
        break;
      case Op::kAtan:
        a = atan(a);
        break;
      case Op::kAtan2:
        a = atan2(a, *b);
        break;
      case Op::kSinh:
        a = sinh(a);
        break;
      case Op::kCosh:
        a = cosh(a);
        break;
      case Op::kTanh:
        a = tanh(a);
        break;
      case Op::kExp:
        a = exp(a);
        break;
      case Op::kLog:
        a = log(a);
        break;
      case Op::kSqrt:
        a = sqrt(a);
        break;
      case Op::kAbs:
        a = abs(a);
        break;
      case Op::kSign:
        a = sign(a);
        break;
      case Op::kMin:
        a = min(a, *b);
        break;
      case Op::kMax:
        a = max(a, *b);
        break;
    }
  }
  return end[-1];
}

Expression Expression::Constant(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  Expression expression;
  expression.text_ = text;
  expression.tape_.push_back({Op::kConstant, 0, value});
  expression.stack_size_ = 1;
  return expression;
}

double Expression::Evaluate(const double* values) const {
  return Run<double>(tape_, stack_size_, values);
}

Taylor3 Expression::Evaluate(const Taylor3* values) const {
  return Run<Taylor3>(tape_, stack_size_, values);
}

bool Expression::DependsOn(int i) const {
  return std::any_of(tape_.begin(), tape_.end(), [i](const Instruction& step) {
    return step.op == Op::kVariable && step.variable == i;
  });
}

bool Expression::IsConstant() const {
  return std::none_of(
      tape_.begin(), tape_.end(), [](const Instruction& step) { return step.op == Op::kVariable; });
}

}  // namespace darboux
