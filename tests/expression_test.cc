#include "geometry/expression.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace darboux {
namespace {

const std::vector<std::string>& Variables() {
  static const auto* const kVariables = new std::vector<std::string>{"u", "v"};
  return *kVariables;
}

Expression ParseOrDie(const std::string& text) {
  std::string error;
  std::optional<Expression> expression = Expression::Parse(text, Variables(), &error);
  EXPECT_TRUE(expression.has_value()) << text << ": " << error;
  return expression.value_or(Expression::Constant(std::nan("")));
}

double Value(const std::string& text, double u = 0.0, double v = 0.0) {
  const std::array<double, 2> uv = {u, v};
  return ParseOrDie(text).Evaluate(uv.data());
}

Taylor3 Jet(const std::string& text, double u, double v) {
  const std::array<Taylor3, 2> uv = {Taylor3::U(u), Taylor3::V(v)};
  return ParseOrDie(text).Evaluate(uv.data());
}

std::string ErrorOf(const std::string& text) {
  std::string error;
  EXPECT_FALSE(Expression::Parse(text, Variables(), &error).has_value()) << text.substr(0, 100);
  return error;
}

std::string Repeat(const std::string& text, int count) {
  std::string repeated;
  for (int i = 0; i < count; ++i) repeated += text;
  return repeated;
}

TEST(ExpressionTest, PrecedenceAndAssociativityAreThoseOfMathematics) {
  EXPECT_EQ(Value("2 + 3*4"), 14.0);
  EXPECT_EQ(Value("(2 + 3)*4"), 20.0);
  EXPECT_EQ(Value("2 - 3 - 4"), -5.0);
  EXPECT_EQ(Value("24/4/2"), 3.0);
  EXPECT_EQ(Value("24/4*2"), 12.0);
  EXPECT_EQ(Value("2^3^2"), 512.0);
  EXPECT_EQ(Value("-2^2"), -4.0);
  EXPECT_EQ(Value("(-2)^2"), 4.0);
  EXPECT_EQ(Value("2^-1"), 0.5);
  EXPECT_EQ(Value("2^-2^2"), 0.0625);
  EXPECT_EQ(Value("2*3^2"), 18.0);
  EXPECT_EQ(Value("-2*-3"), 6.0);
  EXPECT_EQ(Value("2 - -3"), 5.0);
  EXPECT_EQ(Value("--2"), 2.0);
  EXPECT_EQ(Value("+2"), 2.0);
  EXPECT_EQ(Value("1 + 1 < 3"), 1.0);
  EXPECT_EQ(Value("1 < 2 + 3*0"), 1.0);
  EXPECT_EQ(Value("(1 < 2)*5"), 5.0);
}

TEST(ExpressionTest, PrecedenceHoldsForVariablesToo) {  // Which take other paths than constants.
  for (double u : {-1.7, 0.3, 2.0}) {
    for (double v : {-0.4, 1.0, 3.0}) {
      EXPECT_EQ(Value("u + v*4", u, v), u + v * 4.0);
      EXPECT_EQ(Value("u - v - 4", u, v), u - v - 4.0);
      EXPECT_EQ(Value("4 - u - v", u, v), 4.0 - u - v);
      EXPECT_EQ(Value("4 - (u - v)", u, v), 4.0 - (u - v));
      EXPECT_EQ(Value("u/v/2", u, v), u / v / 2.0);
      EXPECT_EQ(Value("2/u/v", u, v), 2.0 / u / v);
      EXPECT_EQ(Value("2/(u/v)", u, v), 2.0 / (u / v));
      EXPECT_EQ(Value("-u^2", u, v), -(u * u));
      EXPECT_EQ(Value("2^u", u, v), std::pow(2.0, u));
      EXPECT_EQ(Value("u*(v - 3*(u + 2))", u, v), u * (v - 3.0 * (u + 2.0)));
      EXPECT_EQ(Value("u<v", u, v), u < v ? 1.0 : 0.0);
      EXPECT_EQ(Value("u*2 < v + 1", u, v), u * 2.0 < v + 1.0 ? 1.0 : 0.0);
    }
  }
}

TEST(ExpressionTest, NumbersAreReadToTheLastBit) {
  EXPECT_EQ(Value("0.1"), 0.1);
  EXPECT_EQ(Value("5."), 5.0);
  EXPECT_EQ(Value(".5"), 0.5);
  EXPECT_EQ(Value("1e3"), 1000.0);
  EXPECT_EQ(Value("1.5E-3"), 1.5e-3);
  EXPECT_EQ(Value("2e+2"), 200.0);
  EXPECT_EQ(Value("1.7976931348623157e308"), std::numeric_limits<double>::max());
  EXPECT_EQ(Value("3.141592653589793"), Value("pi"));
  EXPECT_EQ(Value("  \t1 +\n 2 \r\n"), 3.0);
}

TEST(ExpressionTest, FunctionsAreThoseOfTheStandardLibrary) {
  struct Case {
    std::string text;
    std::function<double(double, double)> f;
  };
  const std::vector<Case> cases = {
      {"sin(u)", [](double u, double) { return std::sin(u); }},
      {"cos(u)", [](double u, double) { return std::cos(u); }},
      {"tan(u)", [](double u, double) { return std::tan(u); }},
      {"asin(u)", [](double u, double) { return std::asin(u); }},
      {"acos(u)", [](double u, double) { return std::acos(u); }},
      {"atan(u)", [](double u, double) { return std::atan(u); }},
      {"atan2(u, v)", [](double u, double v) { return std::atan2(u, v); }},
      {"sinh(u)", [](double u, double) { return std::sinh(u); }},
      {"cosh(u)", [](double u, double) { return std::cosh(u); }},
      {"tanh(u)", [](double u, double) { return std::tanh(u); }},
      {"exp(u)", [](double u, double) { return std::exp(u); }},
      {"log(v)", [](double, double v) { return std::log(v); }},
      {"sqrt(v)", [](double, double v) { return std::sqrt(v); }},
      {"abs(u)", [](double u, double) { return std::abs(u); }},
      {"sign(u)", [](double u, double) { return u > 0.0 ? 1.0 : -1.0; }},
      {"min(u, v)", [](double u, double v) { return std::min(u, v); }},
      {"max(u, v)", [](double u, double v) { return std::max(u, v); }},
      {"v^u", [](double u, double v) { return std::pow(v, u); }},
      {"v^2.5", [](double, double v) { return std::pow(v, 2.5); }},
      {"u^3", [](double u, double) { return std::pow(u, 3.0); }},
      {"u < v", [](double u, double v) { return u < v ? 1.0 : 0.0; }},
      {"u <= v", [](double u, double v) { return u <= v ? 1.0 : 0.0; }},
      {"u > v", [](double u, double v) { return u > v ? 1.0 : 0.0; }},
      {"u >= v", [](double u, double v) { return u >= v ? 1.0 : 0.0; }},
      {"u == v", [](double u, double v) { return u == v ? 1.0 : 0.0; }},
      {"u != v", [](double u, double v) { return u != v ? 1.0 : 0.0; }},
  };
  std::mt19937 gen(38408);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const Case& c : cases) {
    for (int k = 0; k < 10; ++k) {
      const double u = uniform(gen), v = k == 0 ? std::abs(u) : 0.1 + std::abs(uniform(gen));
      EXPECT_DOUBLE_EQ(Value(c.text, u, v), c.f(u, v)) << c.text;
      // The derivatives come with the same value, bit by bit.
      EXPECT_EQ(Jet(c.text, u, v).value(), Value(c.text, u, v)) << c.text;
    }
  }
}

TEST(ExpressionTest, TaylorEvaluationEqualsTheFormulaInCode) {
  std::mt19937 gen(38409);
  std::uniform_real_distribution<double> uniform(0.2, 0.9);
  for (int k = 0; k < 20; ++k) {
    const double u0 = uniform(gen), v0 = uniform(gen);
    const Taylor3 u = Taylor3::U(u0), v = Taylor3::V(v0);
    const Taylor3 expected =
        cos(2.0 * v) * sin(M_PI * u / 600.0) - pow(u, v) / (3.0 - u * atan2(v, u)) + log(u) * -v;
    const Taylor3 actual =
        Jet("cos(2*v)*sin(pi*u/600) - u^v/(3 - u*atan2(v, u)) + log(u)*-v", u0, v0);
    for (int i = 0; i < 10; ++i) {
      EXPECT_NEAR(actual.c[i], expected.c[i], 1e-14 * std::max(1.0, std::abs(expected.c[i])));
    }
  }
}

TEST(ExpressionTest, CubeHasExactDerivativesAtZero) {
  const Taylor3 jet = Jet("u^3 - 3*u*v^2", 0.0, 0.0);
  EXPECT_EQ(jet.c, (std::array<double, 10>{0, 0, 0, 0, 0, 0, 1, 0, -3, 0}));
}

TEST(ExpressionTest, NonFiniteResultsReachTheCaller) {
  EXPECT_TRUE(std::isinf(Value("1/u", 0.0)));
  EXPECT_TRUE(std::isnan(Value("sqrt(u)", -1.0)));
  EXPECT_TRUE(std::isnan(Value("min(0, sqrt(u))", -1.0)));
  EXPECT_TRUE(std::isnan(Value("max(sqrt(u), 0)", -1.0)));
  EXPECT_TRUE(std::isnan(Value("sign(sqrt(u))", -1.0)));
  EXPECT_TRUE(std::isnan(Value("0/0")));
}

TEST(ExpressionTest, KnowsWhatItDependsOn) {
  const Expression both = ParseOrDie("u + sin(v)");
  EXPECT_TRUE(both.DependsOn(0));
  EXPECT_TRUE(both.DependsOn(1));
  EXPECT_FALSE(both.IsConstant());
  const Expression second = ParseOrDie("2*v^2");
  EXPECT_FALSE(second.DependsOn(0));
  EXPECT_TRUE(second.DependsOn(1));
  EXPECT_FALSE(second.DependsOn(2));
  EXPECT_FALSE(second.DependsOn(-1));
  const Expression constant = ParseOrDie("max(1, 2)*sin(pi/2) + 2^-3");
  EXPECT_FALSE(constant.DependsOn(0));
  EXPECT_TRUE(constant.IsConstant());
  EXPECT_EQ(constant.Evaluate(static_cast<const double*>(nullptr)), 2.125);
}

TEST(ExpressionTest, KeepsItsText) {
  EXPECT_EQ(ParseOrDie(" 2*u ").text(), " 2*u ");
  const Expression copy = ParseOrDie("2*u");
  EXPECT_EQ(copy.text(), "2*u");
}

TEST(ExpressionTest, ConstantNeedsNoText) {
  const Expression constant = Expression::Constant(-0.1);
  EXPECT_TRUE(constant.IsConstant());
  EXPECT_EQ(constant.Evaluate(static_cast<const double*>(nullptr)), -0.1);
  EXPECT_EQ(constant.Evaluate(static_cast<const Taylor3*>(nullptr)).c, Taylor3(-0.1).c);
  EXPECT_EQ(std::stod(constant.text()), -0.1);
}

TEST(ExpressionTest, VariablesHaveAnyNameAndNumber) {
  std::string error;
  const auto e = Expression::Parse("x + 10*y_1 + 100*Load2", {"x", "y_1", "Load2"}, &error);
  ASSERT_TRUE(e.has_value()) << error;
  const std::array<double, 3> values = {1.0, 2.0, 3.0};
  EXPECT_EQ(e->Evaluate(values.data()), 321.0);
  EXPECT_TRUE(Expression::Parse("2*pi", {}, &error).has_value());
}

TEST(ExpressionTest, ManyWaitingOperandsAreFine) {
  constexpr int kLevels = 150;  // More than fit into the inline stack.
  const std::string text = Repeat("u+(", kLevels) + "v" + Repeat(")", kLevels);
  EXPECT_EQ(Value(text, 2.0, 1.0), 2.0 * kLevels + 1.0);
  EXPECT_EQ(Jet(text, 2.0, 1.0).c[1], kLevels);
}

TEST(ExpressionTest, LengthIsNotLimited) {
  EXPECT_EQ(Value("0" + Repeat("+u", 100000), 1.0), 100000.0);
  EXPECT_EQ(Value("v" + Repeat("*u", 100000), 1.0, 3.0), 3.0);
}

TEST(ExpressionTest, NestingIsLimitedNotFatal) {
  // The outermost operand is a level of its own.
  const int deepest = Expression::kMaxNesting - 1;
  EXPECT_EQ(Value(Repeat("(", deepest) + "u" + Repeat(")", deepest), 4.0), 4.0);
  const std::string message =
      "nested too deeply; allowed: 200 levels of parentheses, functions, signs and powers";
  EXPECT_EQ(ErrorOf(Repeat("(", 200) + "u" + Repeat(")", 200)), "column 201: " + message);
  for (const char* unit : {"(", "-", "u^", "sin(", "1+(", "2*(-", "min(u,"}) {
    const std::string error = ErrorOf(Repeat(unit, 100000) + "u");
    EXPECT_NE(error.find(message), std::string::npos) << unit << ": " << error;
  }
}

TEST(ExpressionTest, ErrorsSayWhereWhatAndWhatIsAllowed) {
  const std::string known =
      "known: u, v, pi, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, sqrt, "
      "abs, sign, min, max";
  const std::string operand = "; expected a number, a name, '(' or a sign";
  const std::string more = "; expected an operator or the end";
  const std::string multiply = more + " (to multiply, write '*')";
  const std::string characters =
      "; allowed: numbers, names, spaces and + - * / ^ ( ) , < <= > >= == !=";
  const std::string chain =
      "; comparisons do not chain; expected a product such as (0 < u) * (u < 1) instead of "
      "0 < u < 1";
  const std::string range = ", which is out of range; allowed: numbers from 2.3e-308 to 1.7e308";
  struct Case {
    std::string text;
    std::string error;
  };
  const std::vector<Case> cases = {
      // Nothing, or too little.
      {"", "column 1: the expression is empty; expected a formula (" + known + ")"},
      {"  ", "column 1: the expression is empty; expected a formula (" + known + ")"},
      {"u +", "column 4: found the end of the expression" + operand},
      {"*u", "column 1: found '*'" + operand},
      {"u*/v", "column 3: found '/'" + operand},
      {"()", "column 2: found ')'" + operand},
      {"u^", "column 3: found the end of the expression" + operand},
      {"u < ", "column 5: found the end of the expression" + operand},
      // Too much.
      {"2u", "column 2: found 'u'" + multiply},
      {"u v", "column 3: found 'v'" + multiply},
      {"u 2", "column 3: found '2'" + multiply},
      {"(u)(v)", "column 4: found '('" + multiply},
      {"2exp(u)", "column 2: found 'exp'" + multiply},
      {"u)", "column 2: found ')' without a '(' before it" + more},
      {"1,5*u",
       "column 2: found ',' outside a function's arguments" + more + " (a decimal point is '.')"},
      {"0 < u < 1", "column 7: found '<'" + chain},
      {"u == v == 1", "column 8: found '=='" + chain},
      // Parentheses.
      {"2*(u + v",
       "column 9: found the end of the expression; expected an operator or ')' to close the '(' at "
       "column 3"},
      {"(u v)",
       "column 4: found 'v'; expected an operator or ')' to close the '(' at column 1 (to "
       "multiply, write '*')"},
      {"(u, v)", "column 3: found ','; expected an operator or ')' to close the '(' at column 1"},
      {"sin(u",
       "column 6: found the end of the expression; expected an operator, ',' or ')' to close the "
       "'(' at column 4"},
      // Names.
      {"2 + sinn(u)", "column 5: unknown name 'sinn'; did you mean 'sin'? " + known},
      {"sni(u)", "column 1: unknown name 'sni'; did you mean 'sin'? " + known},
      {"U + 1", "column 1: unknown name 'U'; did you mean 'u'? " + known},
      {"2*PI", "column 3: unknown name 'PI'; did you mean 'pi'? " + known},
      {"ln(u)", "column 1: unknown name 'ln'; did you mean 'log'? " + known},
      {"arcsin(u)", "column 1: unknown name 'arcsin'; did you mean 'asin'? " + known},
      {"pow(u, 2)", "column 1: unknown name 'pow'; did you mean '^'? " + known},
      {"e^u", "column 1: unknown name 'e'; did you mean 'exp(1)'? " + known},
      {"u + temperature", "column 5: unknown name 'temperature'; " + known},
      {"w", "column 1: unknown name 'w'; " + known},
      {"nan", "column 1: unknown name 'nan'; did you mean 'tan'? " + known},
      // Functions.
      {"sin u", "column 5: found 'u'; expected '(' after the function 'sin'"},
      {"sin", "column 4: found the end of the expression; expected '(' after the function 'sin'"},
      {"sin()", "column 1: 'sin' takes 1 argument, found none"},
      {"1 + cos(u, v)", "column 5: 'cos' takes 1 argument, found 2"},
      {"min(u)", "column 1: 'min' takes 2 arguments, found 1"},
      {"max(u, v, 1)", "column 1: 'max' takes 2 arguments, found 3"},
      {"atan2()", "column 1: 'atan2' takes 2 arguments, found none"},
      {"min(u,)", "column 7: found ')'" + operand},
      {"v(u + 1)", "column 1: 'v' is a variable, not a function; to multiply, write 'v*(...)'"},
      {"pi(u)", "column 1: 'pi' is a number, not a function; to multiply, write 'pi*(...)'"},
      // Numbers.
      {"1e999", "column 1: found '1e999'" + range},
      {"u*1e-999", "column 3: found '1e-999'" + range},
      {"1.2.3",
       "column 1: found '1.2.3', which is not a number; expected digits with at most one "
       "'.'"},
      {"u + .", "column 5: found '.', which is not a number; expected digits with at most one '.'"},
      {"1e",
       "column 1: found '1e', which is not a number; expected digits after the exponent "
       "sign"},
      {"3e+*u",
       "column 1: found '3e+', which is not a number; expected digits after the exponent "
       "sign"},
      // Characters.
      {"u $ v", "column 3: found '$'" + characters},
      {"u; v", "column 2: found ';'" + characters},
      {std::string("u\0v", 3), "column 2: found '\\x00'" + characters},
      {"\xFF", "column 1: found '\xFF'" + characters},
      {"u = v", "column 3: found '='; did you mean '=='?"},
      {"!u", "column 1: found '!'; did you mean '!='?"},
      {"u**2", "column 2: found '**'; did you mean '^'?"},
      {"[u]", "column 1: found '['; did you mean '('?"},
      {"u \xE2\x88\x92 v", "column 3: found '\xE2\x88\x92'; did you mean '-'?"},
      {"u\xC2\xB2", "column 2: found '\xC2\xB2'; did you mean '^2'?"},
      {"2*\xCF\x80", "column 3: found '\xCF\x80'; did you mean 'pi'?"},
      {"u + \xC3\xA9 + $", "column 5: found '\xC3\xA9'" + characters},
  };
  for (const Case& c : cases) EXPECT_EQ(ErrorOf(c.text), c.error) << c.text;
}

TEST(ExpressionTest, LongNamesAreShortenedInErrors) {
  const std::string error = ErrorOf(std::string(100000, 'a'));
  EXPECT_LT(error.size(), 300u);
  EXPECT_NE(error.find("'" + std::string(40, 'a') + "...'"), std::string::npos) << error;
}

TEST(ExpressionTest, ErrorMayBeIgnored) {
  EXPECT_FALSE(Expression::Parse("u +", Variables(), nullptr).has_value());
}

// Whatever is typed, the parser ends, and either evaluates or says at which column it stopped.
TEST(ExpressionTest, RandomTextNeverCrashes) {
  const std::vector<std::string> pieces = {
      "u",    "v",    "pi", "1",      "2.5",  "1e3", "+",  "-",  "*",       "/",
      "^",    "(",    ")",  ",",      "<",    ">=",  "==", "!=", " ",       "$",
      "sin(", "min(", "x",  "atan2(", "abs(", "..",  "=",  "\n", "\xC2\xB2"};
  std::mt19937 gen(38410);
  std::uniform_int_distribution<size_t> piece(0, pieces.size() - 1), length(0, 12);
  const std::array<Taylor3, 2> uv = {Taylor3::U(0.3), Taylor3::V(-0.7)};
  const std::array<double, 2> values = {0.3, -0.7};
  int parsed = 0;
  for (int k = 0; k < 50000; ++k) {
    std::string text;
    for (size_t i = length(gen); i > 0; --i) text += pieces[piece(gen)];
    std::string error;
    const auto expression = Expression::Parse(text, Variables(), &error);
    if (!expression.has_value()) {
      ASSERT_EQ(error.rfind("column ", 0), 0u) << text << ": " << error;
      ASSERT_LE(std::stoul(error.substr(7)), text.size() + 1) << text << ": " << error;
      ASSERT_EQ(error.find('\n'), std::string::npos) << text << ": " << error;
      continue;
    }
    ++parsed;
    const double value = expression->Evaluate(values.data());
    const Taylor3 jet = expression->Evaluate(uv.data());
    ASSERT_TRUE(value == jet.value() || (std::isnan(value) && std::isnan(jet.value())))
        << text << ": " << value << " is not " << jet.value();
  }
  EXPECT_GT(parsed, 500);
}

// A reference that shares nothing with the parser: random trees, printed with as few parentheses
// as the grammar allows, must come back with the value of the tree.
struct Printed {
  std::string text;
  int level;  // 0 comparison, 1 sum, 2 product, 3 sign, 4 power, 5 primary.
  double value;
};

std::string Wrap(const Printed& p, int level) {
  return p.level >= level ? p.text : "(" + p.text + ")";
}

Printed RandomTree(int depth, const std::array<double, 2>& uv, std::mt19937* gen) {
  const int pick = std::uniform_int_distribution<int>(0, depth == 0 ? 2 : 11)(*gen);
  if (pick == 0) return {"u", 5, uv[0]};
  if (pick == 1) return {"v", 5, uv[1]};
  if (pick == 2) return {"1.5", 5, 1.5};
  const Printed a = RandomTree(depth - 1, uv, gen);
  const Printed b = RandomTree(depth - 1, uv, gen);
  switch (pick) {
    case 3:
      return {Wrap(a, 1) + "+" + Wrap(b, 2), 1, a.value + b.value};
    case 4:
    case 5:
      return {Wrap(a, 1) + " - " + Wrap(b, 2), 1, a.value - b.value};
    case 6:
      return {Wrap(a, 2) + "*" + Wrap(b, 3), 2, a.value * b.value};
    case 7:
      return {Wrap(a, 2) + "/" + Wrap(b, 3), 2, a.value / b.value};
    case 8:
      return {"-" + Wrap(a, 3), 3, -a.value};
    case 9:
      return {Wrap(a, 5) + "^" + Wrap(b, 3), 4, Taylor3::Power(a.value, b.value)};
    case 10:
      return {Wrap(a, 1) + "<=" + Wrap(b, 1), 0, a.value <= b.value ? 1.0 : 0.0};
    default:
      return {"atan2(" + a.text + "," + b.text + ")", 5, std::atan2(a.value, b.value)};
  }
}

TEST(ExpressionTest, RandomTreesSurvivePrintingAndParsing) {
  std::mt19937 gen(38411);
  std::uniform_real_distribution<double> uniform(0.1, 2.0);
  for (int k = 0; k < 20000; ++k) {
    const std::array<double, 2> uv = {uniform(gen), uniform(gen)};
    const Printed tree = RandomTree(5, uv, &gen);
    const double value = Value(tree.text, uv[0], uv[1]);
    ASSERT_TRUE(value == tree.value || (std::isnan(value) && std::isnan(tree.value)))
        << tree.text << " at " << uv[0] << ", " << uv[1] << ": " << value << " is not "
        << tree.value;
  }
}

TEST(ExpressionTest, HundredThousandThirdOrderEvaluationsTakeLessThanASecond) {
#ifdef NDEBUG
  constexpr double kLimit_s = 1.0;
#else
  constexpr double kLimit_s = 30.0;  // Unoptimised or with sanitizers.
#endif
  const Expression expression = ParseOrDie("cos(2*v)*sin(pi*u/600) + u^3 - exp(-u^2 - v^2)");
  const auto start = std::chrono::steady_clock::now();
  double sum = 0.0;
  for (int k = 0; k < 100000; ++k) {
    const std::array<Taylor3, 2> uv = {Taylor3::U(1e-5 * k), Taylor3::V(0.3)};
    sum += expression.Evaluate(uv.data()).c[7];
  }
  const std::chrono::duration<double> elapsed_s = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(std::isfinite(sum));
  EXPECT_LT(elapsed_s.count(), kLimit_s);
}

}  // namespace
}  // namespace darboux
