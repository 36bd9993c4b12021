#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

/// One period of a sine.
TextPicture sine(std::size_t bins, double amplitude) {
  TextPicture p{{}, {}, {}, "residual", "fit", "error [counts]", "angle [deg]"};
  for (std::size_t i = 0; i < bins; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(bins - 1);
    p.at.push_back(360 * part);
    p.points.push_back(amplitude * std::sin(2 * std::numbers::pi * part));
  }
  p.line = p.points;
  return p;
}

TEST(TextPicture, ShowsAStepWithItsTicks) {
  const TextPicture p{{0, 1, 2, 3}, {0, 0, 4, 4}, {}, "residual", "", "error [counts]", "time [s]"};
  EXPECT_EQ(text_picture(p, Style{.ascii = true, .width = 25}, ""),
            "error [counts] against\n"
            "time [s]: o residual\n"
            "4 +              o      o\n"
            "  |\n"
            "3 +\n"
            "  |\n"
            "2 +\n"
            "  |\n"
            "1 +\n"
            "  |\n"
            "0 +o      o\n"
            "  ++-------------+-------\n"
            "   0             2\n");
}

TEST(TextPicture, FitsEveryWidthAndIsEightToTenRowsHigh) {
  for (const bool ascii : {false, true})
    for (std::size_t width = 40; width <= 200; ++width)
      for (const double amplitude : {1e-7, 0.99, 1.0, 37.4, 65536.0}) {
        const std::string text = text_picture(sine(50, amplitude), Style{.ascii = ascii, .width = width});
        const auto lines = lines_of(text);
        EXPECT_GE(lines.size(), 8u + 3) << text;
        EXPECT_LE(lines.size(), 10u + 5) << text;
        for (const std::string& line : lines) EXPECT_LE(display_width(line), width) << text;
      }
}

TEST(TextPicture, UsesAsciiAloneIfAsked) {
  for (const char c : text_picture(sine(30, 3), Style{.ascii = true}))
    EXPECT_TRUE(c == '\n' || (c >= ' ' && c <= '~'));
}

TEST(TextPicture, MarksWherePointsLieOnTheLine) {
  TextPicture p = sine(30, 3);
  EXPECT_NE(text_picture(p, Style{}).find("●"), std::string::npos);
  for (double& value : p.line) value = 0;
  const std::string text = text_picture(p, Style{});
  EXPECT_NE(text.find("•"), std::string::npos);
  EXPECT_NE(text.find("────"), std::string::npos);
}

TEST(TextPicture, LeavesEmptyBinsBlank) {
  TextPicture p{{0, 1, 2, 3, 4, 5},
                {1, 1, NAN, NAN, 1, 1},
                {1, 1, NAN, NAN, 1, 1},
                "residual",
                "fit",
                "error",
                "angle"};
  const auto lines = lines_of(text_picture(p, Style{.ascii = true, .width = 60}, ""));
  const std::string& row = lines[1];
  const std::size_t first = row.find("1 +*");
  ASSERT_NE(first, std::string::npos) << row;
  const std::size_t left = row.find("*", first + 4), right = row.find("*", left + 1);
  ASSERT_NE(right, std::string::npos) << row;
  EXPECT_EQ(row.substr(left + 1, right - left - 1), std::string(right - left - 1, ' ')) << row;
}

TEST(TextPicture, InterpolatesTheLineBetweenDistantBins) {
  TextPicture p{{-1, 1}, {-2, 2}, {-2, 2}, "residual", "fit", "error", "direction"};
  const std::string text = text_picture(p, Style{.ascii = true, .width = 60}, "");
  std::size_t dashes = 0;
  const auto lines = lines_of(text);
  for (std::size_t i = 1; i + 2 < lines.size(); ++i)
    dashes += static_cast<std::size_t>(std::count(lines[i].begin(), lines[i].end(), '-'));
  EXPECT_GE(dashes, 40u) << text;
}

TEST(TextPicture, NeedsTwoPointsAndARange) {
  EXPECT_EQ(text_picture({}, Style{}), "");
  EXPECT_EQ(text_picture({{1}, {2}, {}, "", "", "", ""}, Style{}), "");
  EXPECT_EQ(text_picture({{1, 2}, {NAN, 2}, {}, "", "", "", ""}, Style{}), "");
  EXPECT_EQ(text_picture({{1, 2}, {0, 0}, {}, "", "", "", ""}, Style{}), "");
}

}  // namespace
}  // namespace qerr
