#include "qerr/core/quantity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <locale>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/random.hpp"
#include "core/text.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

std::optional<Quantity> quantity(std::string_view text) {
  std::string why;
  return parse_quantity(text, why);
}

TEST(Quantity, ReadsTheUnitsOfTheContract) {
  const struct {
    const char* text;
    double value;
    Dimension dimension;
  } cases[] = {{"50 Hz", 50, dimension::frequency},
               {"1 kHz", 1e3, dimension::frequency},
               {"0.1 mm", 1e-4, dimension::length},
               {"10 um", 1e-5, dimension::length},
               {"10µm", 1e-5, dimension::length},
               {"15 deg", 15 * pi / 180, dimension::angle},
               {"0.125 mrad", 1.25e-4, dimension::angle},
               {"2 ms", 2e-3, dimension::time},
               {"5 mm/s", 5e-3, dimension::speed},
               {"12 arcmin", 12 * pi / 10800, dimension::angle},
               {"-3e-2 rad/s", -0.03, dimension::angular_speed},
               {"2 N m", 2, dimension::torque},
               {"3 urad/(N m)", 3e-6, dimension::compliance},
               {"1 rev", 2 * pi, dimension::angle},
               {"60 rpm", 2 * pi, dimension::angular_speed},
               {"4 in", 0.1016, dimension::length}};
  for (const auto& c : cases) {
    const auto q = quantity(c.text);
    ASSERT_TRUE(q) << c.text;
    EXPECT_NEAR(q->value, c.value, 1e-15 * std::abs(c.value)) << c.text;
    EXPECT_EQ(q->dimension, c.dimension) << c.text;
  }
  EXPECT_EQ(quantity("2 m/s^2")->dimension, (Dimension{1, 0, -2}));
  EXPECT_FALSE(quantity("7")->dimension);
  EXPECT_EQ(quantity("30 um")->value, 3e-5);
  EXPECT_EQ(quantity("0.3 mm/s")->value, 3e-4);
}

TEST(Quantity, ReadsFractions) {
  EXPECT_EQ(quantity("1/100")->value, 0.01);
  EXPECT_EQ(quantity("-1 / 3")->value, -1.0 / 3);
  EXPECT_EQ(quantity("3/4 mm")->value, 0.75 / 1e3);
  EXPECT_EQ(quantity("3/4 mm")->dimension, dimension::length);
  EXPECT_EQ(quantity("0/5")->value, 0);
  EXPECT_EQ(quantity("2 1/s")->dimension, dimension::frequency);
  for (const char* text : {"1/0", "1/", "1//2", "1/2/3", "/2", "1/-", "1e-200/1e200", "1e200/1e-200"})
    EXPECT_FALSE(quantity(text)) << text;
}

TEST(Quantity, ReadsPartsOfPi) {
  const std::vector<std::pair<std::string, double>> cases{{"pi", std::numbers::pi},
                                                          {"-pi/2", -std::numbers::pi / 2},
                                                          {"3*pi/4", 3 * std::numbers::pi / 4},
                                                          {"0.5 pi", 0.5 * std::numbers::pi},
                                                          {"2 pi rad", 2 * std::numbers::pi}};
  for (const auto& [text, value] : cases) {
    std::string why;
    const auto quantity = parse_quantity(text, why);
    ASSERT_TRUE(quantity) << text << ": " << why;
    EXPECT_DOUBLE_EQ(quantity->value, value) << text;
  }
  for (const char* text : {"pit", "pi2", "2pie", "pi pi", "1/pi*2", "-"}) {
    std::string why;
    EXPECT_FALSE(parse_quantity(text, why)) << text;
  }
}

TEST(Quantity, RejectsTextOtherThanADecimalNumberWithAKnownUnit) {
  for (const char* text : {"",      " ",      "nan", ".nan",  "inf", "-.inf",           "1e400", "1e-400",
                           "0x1F",  "010",    "1,5", "1.2.3", "--1", "5 parsec",        "5 mm/", "5 (mm",
                           "5 mm)", "5 mm^0", "mm",  "e5",    "5e",  "1e-200 nm/1e-200"})
    EXPECT_FALSE(quantity(text)) << text;
}

TEST(Quantity, NamesUnitsSoThatTheyReadBack) {
  for (const Dimension& d :
       {dimension::length, dimension::angle, dimension::speed, dimension::compliance, dimension::torque,
        Dimension{1, 0, -2}, Dimension{0, 1, -3}, dimension::frequency, dimension::angle_per_temperature})
    EXPECT_EQ(quantity("1 " + unit_name(d))->dimension, d) << unit_name(d);
}

TEST(Unit, IsReadByEverySymbolAndPrefixOfTheLists) {
  std::string why;
  for (const UnitSymbol& s : unit_symbols()) {
    const auto alone = parse_unit(s.name, why);
    ASSERT_TRUE(alone) << s.name << ": " << why;
    EXPECT_DOUBLE_EQ(alone->in_si(1), s.factor) << s.name;
    EXPECT_EQ(alone->dimension, s.dimension) << s.name;
    if (!s.prefixable) continue;
    for (const UnitPrefix& p : unit_prefixes()) {
      const auto prefixed = parse_unit(std::string(p.name) + std::string(s.name), why);
      ASSERT_TRUE(prefixed) << p.name << s.name << ": " << why;
      EXPECT_NEAR(prefixed->in_si(1) * p.divisor / p.factor, s.factor, 1e-12 * s.factor) << p.name << s.name;
    }
  }
}

TEST(Unit, HasTheSameScaleAloneAndAfterANumber) {
  for (const std::string unit : {"mrad", "um/s", "N m", "deg", "degC", "1", "%", "rad/(N m)", "ms"}) {
    std::string why;
    const auto alone = parse_unit(unit, why);
    ASSERT_TRUE(alone) << unit << why;
    EXPECT_EQ(alone->in_si(0.3), quantity("0.3 " + unit)->value) << unit;
    EXPECT_EQ(alone->dimension, quantity("0.3 " + unit)->dimension) << unit;
  }
  for (const std::string unit : {"", " ", "5", "m/", "furlong", "[m]"}) {
    std::string why;
    EXPECT_FALSE(parse_unit(unit, why)) << unit;
    EXPECT_NE(why, "") << unit;
  }
}

TEST(Number, IsTheSameInEveryLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  EXPECT_EQ(parse_number("12.5"), 12.5);
  EXPECT_EQ(shortest(12.5), "12.5");
  std::locale::global(before);
}

TEST(Number, ShortestReadsBackAsTheSameDouble) {
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double value = std::ldexp(unit_interval(random_bits(7, i, 0)) - 0.5,
                                    static_cast<int>(random_bits(7, i, 1) % 200) - 100);
    EXPECT_EQ(parse_number(shortest(value)), value);
  }
}

}  // namespace
}  // namespace qerr
