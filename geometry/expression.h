#ifndef DARBOUX_GEOMETRY_EXPRESSION_H_
#define DARBOUX_GEOMETRY_EXPRESSION_H_

#include <optional>
#include <string>
#include <vector>

#include "geometry/taylor.h"

namespace darboux {

// A formula typed by a user, such as "cos(2*v)*sin(pi*u/600)".
//
// Grammar: numbers, pi, the named variables, + - * / ^ (right associative, binds tighter than
// unary minus: -2^2 = -4), parentheses, comparisons < <= > >= == != (1 where true, else 0), and
// sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs sign min max. log is the natural
// logarithm, atan2 takes (y, x), min and max take two arguments. Comparisons bind weakest and do
// not chain: "0 < u < 1" is a mistake, "(0 < u) * (u < 1)" is meant.
//
// Parsed once into a tape; evaluated in double or, for exact derivatives, in truncated Taylor
// arithmetic (geometry/taylor.h, which says what happens where no derivative exists). A result may
// be infinite or NaN (1/u, sqrt(u)): the caller knows where that matters. A NaN is never hidden by
// min, max or sign; a comparison with NaN is false.
class Expression {
 public:
  // Deepest nesting of parentheses, functions, signs and powers; keeps the parser off the end of
  // the call stack.
  static constexpr int kMaxNesting = 200;

  // On a mistake returns nullopt and sets *error to one sentence with the column (1-based), what
  // was found and what is allowed (and the nearest known name).
  static std::optional<Expression> Parse(const std::string& text,
                                         const std::vector<std::string>& variables,
                                         std::string* error);
  static Expression Constant(double value);

  // values: one per variable, in the order given to Parse. Safe to call from several threads.
  double Evaluate(const double* values) const;
  Taylor3 Evaluate(const Taylor3* values) const;

  // Whether the value depends on variable i (of those given to Parse), judged by its appearance in
  // the text: u - u depends on u.
  bool DependsOn(int i) const;
  // Whether it depends on no variable at all.
  bool IsConstant() const;
  const std::string& text() const { return text_; }

 private:
  friend class ExpressionParser;

  enum class Op : unsigned char {
    kConstant,
    kVariable,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kPower,
    // With a constant operand, kept in the instruction: cheaper in Taylor arithmetic.
    kAddConstant,
    kSubtractFromConstant,
    kMultiplyConstant,
    kDivideByConstant,
    kPowerConstant,
    kNegate,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kEqual,
    kNotEqual,
    kSin,
    kCos,
    kTan,
    kAsin,
    kAcos,
    kAtan,
    kAtan2,
    kSinh,
    kCosh,
    kTanh,
    kExp,
    kLog,
    kSqrt,
    kAbs,
    kSign,
    kMin,
    kMax,
  };

  // One step of a stack machine.
  struct Instruction {
    Op op;
    int variable;     // Of kVariable.
    double constant;  // Of kConstant and the operations with a constant operand.
  };

  Expression() = default;

  static int OperandCount(Op op);
  template <typename T>
  static T Run(const std::vector<Instruction>& tape, int stack_size, const T* values);

  std::string text_;
  std::vector<Instruction> tape_;  // Postfix; constant parts are folded.
  int stack_size_ = 0;             // Most operands that wait at any time.
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_EXPRESSION_H_
