#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "input/design_request.hpp"
#include "input/spec_variants.hpp"

namespace qerr {
namespace {

const std::string catalogues = QERR_SOURCE_DIR "/configs/encoders/";

/// An arm with the encoder of a row at its first joint.
Spec with(const CatalogueRow& row) {
  static const SpecVariants variants(
      "qerr: 1\nrobot: {urdf: configs/kuka_lwr/kuka_lwr.urdf}\nencoders: {'*': {bits: 12}}\n",
      QERR_SOURCE_DIR "/arm.yaml");
  std::vector<Node> effects;
  for (const Node& effect : row.effects) effects.push_back(on_joint(effect, "a1"));
  return variants.variant({{"encoders.a1", row.entry}}, effects);
}

const CatalogueRow& named(const Catalogue& catalogue, const std::string& name) {
  for (const CatalogueRow& row : catalogue.rows)
    if (row.name == name) return row;
  throw std::out_of_range(name);
}

TEST(ShippedCatalogues, EveryRowIsAnEncoder) {
  for (const char* file : {"encoders.csv", "joint_or_motor.csv"})
    for (const CatalogueRow& row : read_catalogue(catalogues + file).rows) {
      const Spec spec = with(row);
      const Encoder& encoder = spec.model.transmission.encoders[0];
      EXPECT_GT(encoder.resolution, 1e-9) << row.name;
      EXPECT_LT(encoder.resolution, 0.1) << row.name;
      // Below 2 deg: no unit was mistaken.
      EXPECT_LT(encoder.accuracy * spec.encoder_figures[0].gear_ratio, 0.035) << row.name;
    }
}

TEST(ShippedCatalogues, KnowLinesFromCounts) {
  const Catalogue catalogue = read_catalogue(catalogues + "encoders.csv");
  EXPECT_GE(catalogue.rows.size(), 20u);
  const auto counts = [&](const char* name) {
    return with(named(catalogue, name)).encoder_figures[0].counts_per_rev;
  };
  EXPECT_EQ(counts("AMT102-V"), 8192) << "2048 pulses";
  EXPECT_EQ(counts("RM08I-1024"), 4096) << "counts after decoding";
  EXPECT_EQ(counts("AS5048A"), 16384);
  const Encoder amt = with(named(catalogue, "AMT102-V")).model.transmission.encoders[0];
  EXPECT_NEAR(amt.accuracy, 0.25 * std::numbers::pi / 180, 1e-15);
}

TEST(ShippedCatalogues, BringTheBacklashOfAGear) {
  const Catalogue catalogue = read_catalogue(catalogues + "joint_or_motor.csv");
  EXPECT_EQ(catalogue.price_unit, "EUR");
  EXPECT_EQ(with(named(catalogue, "motor 4096")).effects.size(), 1u);
  EXPECT_EQ(with(named(catalogue, "joint 17 bits")).effects.size(), 0u);
}

TEST(ShippedCatalogues, HaveASourceInEveryRow) {
  std::ifstream file(catalogues + "encoders.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_TRUE(line.ends_with("source,address")) << line;
  while (std::getline(file, line)) {
    EXPECT_FALSE(line.ends_with(",")) << line;
  }
}

}  // namespace
}  // namespace qerr
