#include "report/page/page.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace qerr::page {
namespace {

TEST(Markup, EscapesWhatXmlReadsAndWhatItExcludes) {
  EXPECT_EQ(escaped_markup("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
  EXPECT_EQ(escaped_markup("\x01\xff"), "\uFFFD\uFFFD");
  EXPECT_EQ(escaped_markup("\xEF\xBF\xBF"), "\uFFFD");
  EXPECT_EQ(escaped_markup("\x7F\xC2\x9B\u202Ea\u200Bb"), "\uFFFD\uFFFD\uFFFDa\uFFFDb");
  EXPECT_EQ(escaped_markup("\u200E\u2068\u05D0\n\t\u2069"), "\u200E\u2068\u05D0\n\t\u2069");
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

TEST(Markup, ShortensToTheWidthThatIsLeft) {
  EXPECT_EQ(fitted("a1", 100, 10), "a1");
  for (const char letter : {'i', 'm', 'W'}) {
    const std::string cut = fitted(std::string(60, letter), 100, 10);
    EXPECT_LE(10 * text_width(cut), 100);
    EXPECT_GT(10 * text_width(cut), 80);
  }
  EXPECT_GE(text_width("W"), 0.989);  // advance of DejaVu Sans
  EXPECT_GE(text_width("m"), 0.974);
  EXPECT_GE(text_width("0"), 0.636);
}

TEST(Plot, TellsSeriesApartByShapeAndDashBesideColour) {
  Plot p{"t", "d", {"x", "m"}, {"y", "m"}, {}};
  for (int i = 0; i < 25; ++i) p.series.push_back({"n" + std::to_string(i), {{1.0 + i, 2.0}}, true});
  const std::string svg = figure(p);
  std::set<std::string> styles;
  for (std::size_t at = svg.find("\"mark "); at < svg.find("</svg>"); at = svg.find("\"mark ", at + 1))
    styles.insert(svg.substr(at, svg.find('"', at + 1) - at));
  EXPECT_EQ(styles.size(), 25u);
}

TEST(Plot, DrawsIntervalsInsideItsAxes) {
  const std::string svg =
      figure(Plot{"t", "d", {"x", ""}, {"y", "m"}, {{"a", {{1, 2}}, true, false, {{-3, 8}}}}});
  EXPECT_NE(svg.find("data-from=\"-3\" data-to=\"8\""), std::string::npos) << svg;
  EXPECT_NE(svg.find(">-5</text>"), std::string::npos) << svg;
  EXPECT_NE(svg.find(">10</text>"), std::string::npos) << svg;
}

TEST(Plot, FillsABandBetweenItsBounds) {
  Series s{"bounds", {{0, 0}, {1, 0}}, false, false, {{-1, 1}, {-2, 3}}};
  s.band = true;
  const std::string svg = figure(Plot{"t", "d", {"x", ""}, {"y", ""}, {s}});
  EXPECT_NE(svg.find("data-band=\"0,-1,1 1,-2,3\""), std::string::npos) << svg;
  EXPECT_EQ(svg.find("class=\"error"), std::string::npos);
}

TEST(Plot, NamesALimitThatWouldSqueezeTheData) {
  Plot p{"t", "d", {"x", "m"}, {"y", "m"}, {{"a", {{0, 0}, {1, 1}}}}};
  p.levels = {{"near", 2}, {"far", 50}};
  const std::string svg = figure(p);
  EXPECT_NE(svg.find("data-limit=\"2\""), std::string::npos) << svg;
  EXPECT_EQ(svg.find("data-limit=\"50\""), std::string::npos);
  EXPECT_NE(svg.find("<bdi>far</bdi>: 50.0 m (outside the picture)"), std::string::npos) << svg;
}

TEST(Bars, ShortenNamesBesideLongValues) {
  const std::string svg = figure(Bars{"t", "d", {{std::string(60, 'm'), 1, "12.3 um, 45.6 % of the whole"}}});
  const std::size_t from = svg.find(">", svg.find("class=\"name\"")) + 1;
  const std::string shown = svg.substr(from, svg.find('<', from) - from);
  EXPECT_LE(11 * (text_width(shown) + text_width("12.3 um, 45.6 % of the whole")), 400);
}

TEST(Png, EncodesBytesInBase64) {  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(Png, HasABlockForEvery64Kilobytes) {
  const std::vector<Colour> palette{{0, 0, 0}, {255, 255, 255}};
  const std::string file = png(100, 1000, std::vector<std::uint8_t>(100'000, 1), palette);
  EXPECT_EQ(file.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(file.substr(file.size() - 8), "IEND\xAE\x42\x60\x82");  // its CRC, of every PNG
  const std::size_t data = file.find("IDAT") + 6;                   // behind the header of the stream
  EXPECT_EQ(file.substr(data, 5), std::string("\0\xFF\xFF\0\0", 5));
  EXPECT_EQ(file.substr(data + 5 + 0xFFFF, 5), std::string("\x01\x89\x8A\x76\x75", 5))
      << "101000 bytes in all";
}

TEST(HeatMap, RoundsItsScaleAndLeavesCellsEmpty) {
  const std::string svg =
      figure(HeatMap{"t", "d", {"x", "m"}, {"z", "m"}, {"error", "m"}, {0, 2}, {0, 1}, 2, 1, {3e-6, NAN}});
  EXPECT_NE(svg.find("error [um]"), std::string::npos);
  EXPECT_NE(svg.find("data-span=\"0 2 0 1\""), std::string::npos);
  EXPECT_NE(svg.find("data:image/png;base64,"), std::string::npos);
}

TEST(Script, IsSmallAndEndsNoElementAround) {
  EXPECT_LT(script.size(), 50000u);
  for (const char* end : {"]]>", "</script", "<!--"}) EXPECT_EQ(script.find(end), std::string::npos) << end;
  EXPECT_EQ(style_sheet.find_first_of("<&"), std::string::npos);
}

}  // namespace
}  // namespace qerr::page
