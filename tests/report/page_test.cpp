#include <gtest/gtest.h>

#include <cmath>

#include "report/page/axis.hpp"
#include "report/page/markup.hpp"
#include "report/page/page_style.hpp"
#include "report/page/plot.hpp"

namespace qerr::page {
namespace {

TEST(Markup, EscapesWhatXmlReadsAndWhatItExcludes) {
  EXPECT_EQ(escaped_markup("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
  EXPECT_EQ(escaped_markup("\x01\xff"), "\uFFFD\uFFFD");
  EXPECT_EQ(escaped_markup("\xEF\xBF\xBF"), "\uFFFD");
  EXPECT_EQ(name_markup("\u05D0"), "<bdi>\u05D0</bdi>");
}

TEST(Markup, ShortensInTheMiddleByCodePoints) {
  EXPECT_EQ(shortened("shoulder", 8), "shoulder");
  EXPECT_EQ(shortened("\u05D0\u05D1\u05D2\u05D3\u05D4", 3), "\u05D0\u2026\u05D4");
}

TEST(Axis, HasRoundTicksThatContainTheData) {
  for (const double least : {-3.7, 0.0, 1e-6, 9.99e5})
    for (const double width : {0.0, 1e-7, 0.3, 47.0, 8e6}) {
      const Axis a = axis({"error", "m"}, least, least + width);
      EXPECT_LE(a.from, least + 1e-9 * std::abs(least) + 1e-9 * width);
      EXPECT_GE(a.to, least + width - 1e-9 * std::abs(least) - 1e-9 * width);
      ASSERT_GE(a.ticks.size(), 2u);
      const double step = a.ticks[1].value - a.ticks[0].value;
      const double digit = step / std::pow(10, std::floor(std::log10(step) + 1e-6));
      EXPECT_TRUE(std::abs(digit - 1) < 1e-3 || std::abs(digit - 2) < 1e-3 || std::abs(digit - 5) < 1e-3)
          << step;
    }
}

TEST(Axis, NamesTheUnitWithItsPrefix) {
  const Axis a = axis({"error", "m"}, 0, 123e-6);
  EXPECT_EQ(a.title, "error [um]");
  EXPECT_EQ(a.ticks.back().label, "150");
  EXPECT_NEAR(a.part(75e-6), 0.5, 1e-12);
}

TEST(Axis, IsLogarithmicFromPowerToPowerOfTen) {
  const Axis a = axis({"gain", "1/s", true}, 3, 4e5);
  EXPECT_DOUBLE_EQ(a.from, 1);
  EXPECT_DOUBLE_EQ(a.to, 1e6);
  EXPECT_NEAR(a.part(1e3), 0.5, 1e-12);
}

TEST(Plot, LeavesOutWhatItsAxesCannotShow) {
  const std::string svg =
      figure(Plot{"t", "d", {"f", "Hz", true}, {"g", ""}, {{"<s>", {{1, 2}, {0, 5}, {10, NAN}, {100, 4}}}}});
  EXPECT_NE(svg.find("data-points=\"1,2 100,4\""), std::string::npos) << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("<s>"), std::string::npos);
}

TEST(Script, IsSmallAndNeedsNoEscapes) {
  EXPECT_LT(script.size(), 5000u);
  EXPECT_EQ((std::string(script) + std::string(style_sheet)).find_first_of("<&"), std::string::npos);
}

}  // namespace
}  // namespace qerr::page
