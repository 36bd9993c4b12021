#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "input/design_request.hpp"
#include "input/yaml_tree.hpp"

namespace qerr {
namespace {

class CatalogueFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() /
             ("qerr_catalogue_" + std::to_string(getpid()) + '_' +
              ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  Catalogue read(const std::string& text) {
    std::ofstream(folder / "encoders.csv", std::ios::binary) << text;
    return read_catalogue((folder / "encoders.csv").string());
  }

  /// Place and key, rule of every fault; "accepted" without one.
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const Error& e) {
      std::string all;
      for (const Fault& f : e.faults())
        all += std::to_string(f.place.line) + ':' + std::to_string(f.place.column) + ' ' + f.key + ": " +
               f.rule + '\n';
      return all;
    }
    return "accepted";
  }

  std::filesystem::path folder;
};

TEST_F(CatalogueFile, RowsAreEntriesOfASpec) {
  const Catalogue c = read(
      "# what we could buy\n"
      "name,price [EUR],bits,lines_per_rev,accuracy [arcsec],gear_ratio,backlash [arcmin],maker\n"
      "AS5047,12.5,14,,2880,,,\"ams, Premstaetten\"\n"
      "HEDL,0,,500,3 arcmin,-1/100,1.5,\n");
  ASSERT_EQ(c.rows.size(), 2u);
  EXPECT_EQ(c.price_unit, "EUR");
  EXPECT_EQ(c.rows[0].name, "AS5047");
  EXPECT_EQ(c.rows[0].price, 12.5);
  EXPECT_EQ(flow(c.rows[0].entry), "{bits: 14, accuracy: 2880 arcsec}");
  EXPECT_TRUE(c.rows[0].effects.empty());
  EXPECT_EQ(flow(c.rows[1].entry), "{lines_per_rev: 500, accuracy: 3 arcmin, gear_ratio: '-1/100'}");
  ASSERT_EQ(c.rows[1].effects.size(), 1u);
  EXPECT_EQ(flow(on_joint(c.rows[1].effects[0], "elbow")), "{type: backlash, joint: elbow, gap: 1.5 arcmin}");
  EXPECT_EQ(c.rows[1].place.line, 4);
  EXPECT_EQ(c.rows[1].entry.find("accuracy")->place.column, 13);
}

TEST_F(CatalogueFile, MayBeSeparatedBySemicolonsAndHaveDecimalCommas) {
  const Catalogue c = read(
      "name;price [EUR];bits;accuracy;backlash [arcmin];maker\nA, small;12,5;14;0,05 deg;1,5;\"x; y, "
      "1,5\"\n");
  ASSERT_EQ(c.rows.size(), 1u);
  EXPECT_EQ(c.rows[0].name, "A, small");
  EXPECT_EQ(c.rows[0].price, 12.5);
  EXPECT_EQ(flow(c.rows[0].entry), "{bits: 14, accuracy: 0.05 deg}");
  EXPECT_EQ(flow(on_joint(c.rows[0].effects[0], "j")), "{type: backlash, joint: j, gap: 1.5 arcmin}");
  EXPECT_NE(refusal("name;price;bits\na;1.234,50;12\n").find("must be a number"), std::string::npos);
}

TEST_F(CatalogueFile, EmptyRowsAtTheEndAreNone) {
  EXPECT_EQ(read("name,price,bits\nA,1,14\nB,2,15\n,,\n,,\n").rows.size(), 2u);
  EXPECT_EQ(read("name;price;bits\nA;1,5;14\n;;\r\n;;").rows.size(), 1u);
  EXPECT_NE(refusal("name,price,bits\nA,1,14\n,,\nB,2,15\n").find("the row has no name"), std::string::npos);
}

TEST_F(CatalogueFile, AnEmptyPriceIsNoPrice) {
  EXPECT_FALSE(read("name,price,bits\na,,12\n").rows[0].price.has_value());
  EXPECT_FALSE(read("name,bits\na,12\n").rows[0].price.has_value());
}

TEST_F(CatalogueFile, EffectsWithSeveralParametersNameThem) {
  const Catalogue c = read("name,bits,eccentricity.amplitude [mrad],eccentricity.phase\na,12,0.2,30 deg\n");
  EXPECT_EQ(flow(on_joint(c.rows[0].effects[0], "j")),
            "{type: eccentricity, joint: j, amplitude: 0.2 mrad, phase: 30 deg}");
  EXPECT_NE(refusal("name,bits,eccentricity.size\na,12,1\n").find("no such parameter"), std::string::npos);
}

TEST_F(CatalogueFile, TellsEveryFaultWithItsPlace) {
  EXPECT_EQ(
      refusal("name,price,bits\na,1,12\nb,-3,13\na,2,14\n,2,15\n"),
      "3:3 price: must be a number from 0 to 1e9\n4:1 name: duplicate name, as in line 2\n5:1 name: the row "
      "has no name\n");
  EXPECT_EQ(refusal("part,bits\na,12\n"), "1:1 name: the catalogue has no column of this name\n");
  EXPECT_EQ(refusal("name,bits,acuracy\na,12,1\n"),
            "1:11 acuracy: unknown column, and nearly one that is known\n");
  for (const char* spelling : {"Accuracy [arcmin]", "accuracy (arcmin)", "accuracy_arcmin", "ACCURACY",
                               "Gear-Ratio", "Max frequency"})
    EXPECT_NE(refusal("name,bits," + std::string(spelling) + "\na,12,1\n")
                  .find("is not how this column is written"),
              std::string::npos)
        << spelling;
  EXPECT_EQ(refusal("name,bits,bits\na,12,1\n"), "1:11 bits: duplicate column\n");
  EXPECT_NE(refusal("name,cpr\na,12\n").find("ambiguous"), std::string::npos);
  EXPECT_EQ(refusal("name,bits\n"), "1:1 : the catalogue has no rows\n");
  EXPECT_NE(refusal("name,bits\na,12,13\n").find("as many cells"), std::string::npos);
  for (const char* described :
       {"interface", "kind", "mounting", "source", "maker", "diameter [mm]", "supply"})
    EXPECT_EQ(refusal(std::string("name,bits,") + described + "\na,12,\n"), "accepted");
}

}  // namespace
}  // namespace qerr
