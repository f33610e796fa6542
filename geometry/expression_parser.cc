#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "geometry/expression.h"
#include "geometry/nearest_name.h"

namespace darboux {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsNameStart(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool IsNamePart(char c) { return IsNameStart(c) || IsDigit(c); }
bool IsContinuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }  // Of UTF-8.

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

// In quotes, shortened and free of control characters, so that a message stays one line.
std::string Quote(std::string_view text) {
  constexpr size_t kMaxLength = 40;
  std::string quoted = "'";
  for (size_t i = 0; i < text.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(text[i]);
    if (i >= kMaxLength && !IsContinuation(text[i])) {
      quoted += "...";
      break;
    }
    if (c < 0x20 || c == 0x7F) {
      char code[8];
      std::snprintf(code, sizeof(code), "\\x%02X", static_cast<unsigned int>(c));
      quoted += code;
    } else {
      quoted += text[i];
    }
  }
  return quoted + "'";
}

// What people write for things that have another name here.
struct Synonym {
  const char* wrong;
  const char* right;
};
constexpr Synonym kNameSynonyms[] = {
    {"ln", "log"},
    {"e", "exp(1)"},
    {"arcsin", "asin"},
    {"arccos", "acos"},
    {"arctan", "atan"},
    {"arctan2", "atan2"},
    {"pow", "^"},
    {"fabs", "abs"},
    {"sgn", "sign"},
    {"log10", "log(...)/log(10)"},
    {"log2", "log(...)/log(2)"},
};
constexpr Synonym kCharacterSynonyms[] = {
    {"\xE2\x88\x92", "-"},          // Minus sign.
    {"\xE2\x80\x93", "-"},          // En dash.
    {"\xC3\x97", "*"},              // Times.
    {"\xC2\xB7", "*"},              // Middle dot.
    {"\xE2\x8B\x85", "*"},          // Dot operator.
    {"\xC3\xB7", "/"},              // Division sign.
    {"\xC2\xB2", "^2"},             // Squared.
    {"\xC2\xB3", "^3"},             // Cubed.
    {"\xCF\x80", "pi"},             // Greek pi.
    {"\xE2\x88\x9A", "sqrt"},       // Root.
    {"\xE2\x89\xA4", "<="},         // Less or equal.
    {"\xE2\x89\xA5", ">="},         // Greater or equal.
    {"\xE2\x89\xA0", "!="},         // Not equal.
    {"\xC2\xA0", "a plain space"},  // No-break space.
    {"=", "=="},
    {"!", "!="},
    {"**", "^"},
    {"[", "("},
    {"]", ")"},
    {"{", "("},
    {"}", ")"},
};

}  // namespace

// Recursive descent, one function per rule, lowest precedence first:
//
//   comparison = sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]
//   sum        = product {("+" | "-") product}
//   product    = unary {("*" | "/") unary}
//   unary      = ("+" | "-") unary | power
//   power      = primary ["^" unary]
//   primary    = number | variable | "pi" | function "(" comparison {"," comparison} ")"
//              | "(" comparison ")"
//
// Each function writes its operand to the end of the tape and returns false after a mistake.
class ExpressionParser {
 public:
  ExpressionParser(const std::string& text, const std::vector<std::string>& variables)
      : text_(text), variables_(variables) {}

  std::optional<Expression> Parse() {
    Advance();
    if (token_.kind == Kind::kEnd) {
      FailAt(0, "the expression is empty; expected a formula (known: " + KnownNames() + ")");
      return std::nullopt;
    }
    if (!Comparison()) return std::nullopt;
    if (token_.kind != Kind::kEnd) {
      if (IsSymbol(")")) {
        FailAt(token_.begin, "found ')' without a '(' before it; expected an operator or the end");
      } else if (IsSymbol(",")) {
        FailAt(token_.begin,
               "found ',' outside a function's arguments; expected an operator or the end (a "
               "decimal point is '.')");
      } else {
        UnexpectedAfterOperand("expected an operator or the end");
      }
      return std::nullopt;
    }
    Expression expression;
    expression.text_ = text_;
    expression.tape_ = std::move(tape_);
    int size = 0;
    for (const Instruction& step : expression.tape_) {
      size += 1 - Expression::OperandCount(step.op);
      expression.stack_size_ = std::max(expression.stack_size_, size);
    }
    return expression;
  }

  const std::string& error() const { return error_; }

 private:
  using Op = Expression::Op;
  using Instruction = Expression::Instruction;

  enum class Kind { kEnd, kNumber, kName, kSymbol, kBad };
  struct Token {
    Kind kind = Kind::kEnd;
    size_t begin = 0;
    std::string_view text;
    double number = 0.0;
    std::string problem;  // Of kBad: what is wrong with it.
  };

  struct Function {
    const char* name;
    Op op;
  };
  static constexpr Function kFunctions[] = {
      {"sin", Op::kSin},
      {"cos", Op::kCos},
      {"tan", Op::kTan},
      {"asin", Op::kAsin},
      {"acos", Op::kAcos},
      {"atan", Op::kAtan},
      {"atan2", Op::kAtan2},
      {"sinh", Op::kSinh},
      {"cosh", Op::kCosh},
      {"tanh", Op::kTanh},
      {"exp", Op::kExp},
      {"log", Op::kLog},
      {"sqrt", Op::kSqrt},
      {"abs", Op::kAbs},
      {"sign", Op::kSign},
      {"min", Op::kMin},
      {"max", Op::kMax},
  };
  struct Symbol {
    const char* text;
    Op op;
  };
  static constexpr Symbol kComparisons[] = {
      {"<", Op::kLess},
      {"<=", Op::kLessEqual},
      {">", Op::kGreater},
      {">=", Op::kGreaterEqual},
      {"==", Op::kEqual},
      {"!=", Op::kNotEqual},
  };

  // ---- Lexer ----

  void Advance() {
    size_t i = token_.begin + token_.text.size();
    while (i < text_.size() &&
           (text_[i] == ' ' || text_[i] == '\t' || text_[i] == '\n' || text_[i] == '\r')) {
      ++i;
    }
    token_ = Token();
    token_.begin = i;
    if (i == text_.size()) return;
    if (IsDigit(text_[i]) || text_[i] == '.') {
      ReadNumber();
    } else if (IsNameStart(text_[i])) {
      size_t end = i;
      while (end < text_.size() && IsNamePart(text_[end])) ++end;
      SetToken(Kind::kName, end);
    } else {
      ReadSymbol();
    }
  }

  void SetToken(Kind kind, size_t end) {
    token_.kind = kind;
    token_.text = std::string_view(text_).substr(token_.begin, end - token_.begin);
  }

  void SetBadToken(size_t end, const std::string& problem) {
    SetToken(Kind::kBad, end);
    token_.problem = "found " + Quote(token_.text) + problem;
  }

  char At(size_t i) const { return i < text_.size() ? text_[i] : '\0'; }

  void ReadNumber() {
    size_t end = token_.begin;
    bool has_digits = false;
    for (; IsDigit(At(end)); ++end) has_digits = true;
    if (At(end) == '.') {
      for (++end; IsDigit(At(end)); ++end) has_digits = true;
    }
    if (At(end) == '.' || !has_digits) {
      while (IsDigit(At(end)) || At(end) == '.') ++end;
      SetBadToken(end, ", which is not a number; expected digits with at most one '.'");
      return;
    }
    if (At(end) == 'e' || At(end) == 'E') {
      size_t exponent = end + 1;
      if (At(exponent) == '+' || At(exponent) == '-') ++exponent;
      if (IsDigit(At(exponent))) {
        for (end = exponent; IsDigit(At(end));) ++end;
      } else if (!IsNamePart(At(end + 1))) {  // But 2exp(u) lacks an operator, not an exponent.
        SetBadToken(exponent, ", which is not a number; expected digits after the exponent sign");
        return;
      }
    }
    SetToken(Kind::kNumber, end);
    // Unlike strtod, independent of the locale's decimal point.
    const char* const first = token_.text.data();
    const std::from_chars_result result =
        std::from_chars(first, first + token_.text.size(), token_.number);
    if (result.ec != std::errc() || !std::isfinite(token_.number)) {
      SetBadToken(end, ", which is out of range; allowed: numbers from 2.3e-308 to 1.7e308");
    }
  }

  void ReadSymbol() {
    const size_t i = token_.begin;
    for (const char* two : {"<=", ">=", "==", "!="}) {
      if (text_.compare(i, 2, two) == 0) {
        SetToken(Kind::kSymbol, i + 2);
        return;
      }
    }
    const bool power = text_.compare(i, 2, "**") == 0;
    if (!power && std::string_view("+-*/^(),<>").find(text_[i]) != std::string_view::npos) {
      SetToken(Kind::kSymbol, i + 1);
      return;
    }
    size_t end = i + (power ? 2 : 1);
    while (end < text_.size() && IsContinuation(text_[end])) ++end;
    const std::string_view found = std::string_view(text_).substr(i, end - i);
    for (const Synonym& synonym : kCharacterSynonyms) {
      if (found == synonym.wrong) {
        SetBadToken(end, "; did you mean " + Quote(synonym.right) + "?");
        return;
      }
    }
    SetBadToken(end, "; allowed: numbers, names, spaces and + - * / ^ ( ) , < <= > >= == !=");
  }

  bool IsSymbol(std::string_view symbol) const {
    return token_.kind == Kind::kSymbol && token_.text == symbol;
  }

  // ---- Messages ----

  // Bytes are characters here: nothing beyond ASCII can come before the first mistake.
  static std::string ColumnOf(size_t offset) { return "column " + std::to_string(offset + 1); }

  bool FailAt(size_t offset, const std::string& message) {
    error_ = ColumnOf(offset) + ": " + message;
    return false;
  }

  // The current token is none of those that the grammar allows here.
  bool Unexpected(const std::string& expected) {
    if (token_.kind == Kind::kBad) return FailAt(token_.begin, token_.problem);
    const std::string found =
        token_.kind == Kind::kEnd ? "the end of the expression" : Quote(token_.text);
    return FailAt(token_.begin, "found " + found + "; " + expected);
  }

  // As Unexpected, where an operand has just ended.
  bool UnexpectedAfterOperand(const std::string& expected) {
    const bool starts_operand =
        token_.kind == Kind::kNumber || token_.kind == Kind::kName || IsSymbol("(");
    return Unexpected(expected + (starts_operand ? " (to multiply, write '*')" : ""));
  }

  std::string KnownNames() const {
    std::string names;
    const auto append = [&names](const std::string& name) {
      names += (names.empty() ? "" : ", ") + name;
    };
    for (const std::string& variable : variables_) append(variable);
    append("pi");
    for (const Function& function : kFunctions) append(function.name);
    return names;
  }

  bool UnknownName(const Token& name, bool is_call) {
    std::string best;
    for (const Synonym& synonym : kNameSynonyms) {
      if (Lower(name.text) == synonym.wrong) best = synonym.right;
    }
    if (best.empty()) {
      std::vector<std::string> known;
      if (!is_call) {
        known = variables_;
        known.push_back("pi");
      }
      for (const Function& function : kFunctions) known.push_back(function.name);
      best = NearestName(std::string(name.text), known, Spelling::kFormula);
    }
    std::string message = "unknown name " + Quote(name.text) + "; ";
    if (!best.empty()) message += "did you mean " + Quote(best) + "? ";
    return FailAt(name.begin, message + "known: " + KnownNames());
  }

  // ---- Tape ----

  bool IsConstant(size_t begin, size_t end) const {
    return end - begin == 1 && tape_[begin].op == Op::kConstant;
  }

  void PushConstant(double value) { tape_.push_back({Op::kConstant, 0, value}); }

  // Replaces the tape from begin on, which has only constant operands, by its value.
  void Fold(size_t begin) {
    Expression part;
    part.tape_.assign(tape_.begin() + static_cast<std::ptrdiff_t>(begin), tape_.end());
    part.stack_size_ = 2;
    tape_.resize(begin);
    PushConstant(part.Evaluate(static_cast<const double*>(nullptr)));
  }

  // The operand is everything from begin on.
  void EmitUnary(Op op, size_t begin) {
    const bool constant = IsConstant(begin, tape_.size());
    tape_.push_back({op, 0, 0.0});
    if (constant) Fold(begin);
  }

  // The operands are [left, right) and everything from right on.
  void EmitBinary(Op op, size_t left, size_t right) {
    const bool left_constant = IsConstant(left, right);
    const bool right_constant = IsConstant(right, tape_.size());
    if (left_constant && right_constant) {
      tape_.push_back({op, 0, 0.0});
      Fold(left);
    } else if (right_constant && HasConstantForm(op)) {
      const double value = tape_.back().constant;
      tape_.pop_back();
      EmitConstantForm(op, value, false);
    } else if (left_constant && op != Op::kDivide && op != Op::kPower && HasConstantForm(op)) {
      const double value = tape_[left].constant;
      tape_.erase(tape_.begin() + static_cast<std::ptrdiff_t>(left));
      EmitConstantForm(op, value, true);
    } else {
      tape_.push_back({op, 0, 0.0});
    }
  }

  static bool HasConstantForm(Op op) {
    return op == Op::kAdd || op == Op::kSubtract || op == Op::kMultiply || op == Op::kDivide ||
           op == Op::kPower;
  }

  // All of these round exactly as the operation on two operands does.
  void EmitConstantForm(Op op, double value, bool constant_is_left) {
    switch (op) {
      case Op::kAdd:
        tape_.push_back({Op::kAddConstant, 0, value});
        break;
      case Op::kSubtract:
        if (constant_is_left) {
          tape_.push_back({Op::kSubtractFromConstant, 0, value});
        } else {
          tape_.push_back({Op::kAddConstant, 0, -value});
        }
        break;
      case Op::kMultiply:
        tape_.push_back({Op::kMultiplyConstant, 0, value});
        break;
      case Op::kDivide:
        tape_.push_back({Op::kDivideByConstant, 0, value});
        break;
      default:
        tape_.push_back({Op::kPowerConstant, 0, value});
        break;
    }
  }

  // ---- Grammar ----

  const Symbol* ComparisonSymbol() const {
    for (const Symbol& symbol : kComparisons) {
      if (IsSymbol(symbol.text)) return &symbol;
    }
    return nullptr;
  }

  bool Comparison() {
    const size_t left = tape_.size();
    if (!Sum()) return false;
    const Symbol* const symbol = ComparisonSymbol();
    if (symbol == nullptr) return true;
    Advance();
    const size_t right = tape_.size();
    if (!Sum()) return false;
    EmitBinary(symbol->op, left, right);
    if (ComparisonSymbol() != nullptr) {
      return Unexpected(
          "comparisons do not chain; expected a product such as (0 < u) * (u < 1) instead of "
          "0 < u < 1");
    }
    return true;
  }

  bool Sum() {
    const size_t left = tape_.size();
    if (!Product()) return false;
    while (IsSymbol("+") || IsSymbol("-")) {
      const Op op = IsSymbol("+") ? Op::kAdd : Op::kSubtract;
      Advance();
      const size_t right = tape_.size();
      if (!Product()) return false;
      EmitBinary(op, left, right);
    }
    return true;
  }

  bool Product() {
    const size_t left = tape_.size();
    if (!Unary()) return false;
    while (IsSymbol("*") || IsSymbol("/")) {
      const Op op = IsSymbol("*") ? Op::kMultiply : Op::kDivide;
      Advance();
      const size_t right = tape_.size();
      if (!Unary()) return false;
      EmitBinary(op, left, right);
    }
    return true;
  }

  // Every cycle of the grammar passes through here, so this is where nesting is counted.
  bool Unary() {
    if (nesting_ == Expression::kMaxNesting) {
      return FailAt(token_.begin,
                    "nested too deeply; allowed: " + std::to_string(Expression::kMaxNesting) +
                        " levels of parentheses, functions, signs and powers");
    }
    ++nesting_;
    const bool ok = SignedPower();
    --nesting_;
    return ok;
  }

  bool SignedPower() {
    if (!IsSymbol("+") && !IsSymbol("-")) return Power();
    const bool negative = IsSymbol("-");
    Advance();
    const size_t begin = tape_.size();
    if (!Unary()) return false;
    if (negative) EmitUnary(Op::kNegate, begin);
    return true;
  }

  bool Power() {
    const size_t left = tape_.size();
    if (!Primary()) return false;
    if (!IsSymbol("^")) return true;
    Advance();
    const size_t right = tape_.size();
    if (!Unary()) return false;
    EmitBinary(Op::kPower, left, right);
    return true;
  }

  bool Primary() {
    if (token_.kind == Kind::kNumber) {
      PushConstant(token_.number);
      Advance();
      return true;
    }
    if (token_.kind == Kind::kName) return Name();
    if (IsSymbol("(")) {
      const size_t open = token_.begin;
      Advance();
      return Comparison() && Close(open, "");
    }
    return Unexpected("expected a number, a name, '(' or a sign");
  }

  bool Close(size_t open, const std::string& also) {
    if (IsSymbol(")")) {
      Advance();
      return true;
    }
    return UnexpectedAfterOperand("expected an operator" + also + " or ')' to close the '(' at " +
                                  ColumnOf(open));
  }

  bool Name() {
    const Token name = token_;
    Advance();
    const bool is_call = IsSymbol("(");
    for (size_t i = 0; i < variables_.size(); ++i) {
      if (name.text != variables_[i]) continue;
      tape_.push_back({Op::kVariable, static_cast<int>(i), 0.0});
      return !is_call || NotAFunction(name, "variable");
    }
    if (name.text == "pi") {
      PushConstant(M_PI);
      return !is_call || NotAFunction(name, "number");
    }
    for (const Function& function : kFunctions) {
      if (name.text == function.name) return Call(name, function.op);
    }
    return UnknownName(name, is_call);
  }

  bool NotAFunction(const Token& name, const std::string& kind) {
    return FailAt(name.begin,
                  Quote(name.text) + " is a " + kind + ", not a function; to multiply, write " +
                      Quote(std::string(name.text) + "*(...)"));
  }

  bool Call(const Token& name, Op op) {
    const int wanted = Expression::OperandCount(op);
    if (!IsSymbol("(")) {
      return Unexpected("expected '(' after the function " + Quote(name.text));
    }
    const size_t open = token_.begin;
    Advance();
    const size_t first = tape_.size();
    size_t last = first;
    int count = 0;
    if (IsSymbol(")")) {
      Advance();
    } else {
      for (;;) {
        last = tape_.size();
        if (!Comparison()) return false;
        ++count;
        if (!IsSymbol(",")) break;
        Advance();
      }
      if (!Close(open, ", ','")) return false;
    }
    if (count != wanted) {
      return FailAt(name.begin,
                    Quote(name.text) + " takes " + std::to_string(wanted) +
                        (wanted == 1 ? " argument" : " arguments") + ", found " +
                        (count == 0 ? "none" : std::to_string(count)));
    }
    if (wanted == 1) {
      EmitUnary(op, first);
    } else {
      EmitBinary(op, first, last);
    }
    return true;
  }

  const std::string& text_;
  const std::vector<std::string>& variables_;
  Token token_;
  std::vector<Instruction> tape_;
  int nesting_ = 0;
  std::string error_;
};

std::optional<Expression> Expression::Parse(const std::string& text,
                                            const std::vector<std::string>& variables,
                                            std::string* error) {
  ExpressionParser parser(text, variables);
  std::optional<Expression> expression = parser.Parse();
  if (!expression.has_value() && error != nullptr) *error = parser.error();
  return expression;
}

}  // namespace darboux
