#include <gtest/gtest.h>

#include <limits>

#include "qerr/report/analysis.hpp"
#include "report/formats.hpp"

namespace qerr {
namespace {

struct Part {
  std::string name;
  double mass = 0;
};

struct Toy {
  double mass = 2;
  std::string owner = {};
  std::optional<double> price = {};
  std::vector<Part> parts = {};
  bool loud = false;
};

RowsOf<Part> rows(Of<Part>) { return {{"name", &Part::name}, {"mass", &Part::mass, "[kg]", nullable}}; }

RowsOf<Toy> rows(Of<Toy>) {
  return {
      {"mass", &Toy::mass, "[kg]"}, {"owner", &Toy::owner, optional},
      {"price", &Toy::price},       {"parts", &Toy::parts},
      {"loud", &Toy::loud},
  };
}

const Json& property(const Json& schema, std::string_view name) {
  return schema.at("properties").at(std::string(name));
}

TEST(ReportRows, AFieldIsOneRowThatJsonAndSchemaHave) {
  const Toy toy;
  const RowsOf<Toy> more =
      rows(Of<Toy>()).with({{"double_mass", [](auto& t) { return 2 * t.mass; }, "twice [kg]"}});
  EXPECT_EQ(object_of(rows_of<Toy>(), &toy).contains("double_mass"), false);
  EXPECT_EQ(line(object_of(more.list, &toy).at("double_mass")), "4.0");
  EXPECT_EQ(line(property(schema_of(more.list), "double_mass")),
            R"({"type":"number","description":"twice [kg]"})");
}

TEST(ReportRows, AFieldOfAReportIsOneRow) {
  const ThresholdReport report{{{.robot = "arm", .joint = "elbow"}}};
  const RowsOf<ThresholdReport> more =
      rows(Of<ThresholdReport>()).with({{"toy", [](auto& r) { return r.rows.front().robot; }}});
  EXPECT_EQ(line(object_of(more.list, &report).at("toy")), "\"arm\"");
  EXPECT_EQ(line(property(schema_of(more.list), "toy")), R"({"type":"string"})");
  const Json schema = schema_of(more.list);
  EXPECT_EQ(line(schema.at("required")), R"(["qerr","command","robots","toy"])");
}

TEST(ReportRows, AMemberWithoutAValueIsNullOrAbsentAsItsSchemaSays) {
  Toy toy;
  EXPECT_EQ(line(json_of(toy)), R"({"mass":2.0,"price":null,"parts":[],"loud":false})");
  toy.owner = "Eve";
  toy.price = 3;
  toy.parts = {{"wheel", std::numeric_limits<double>::infinity()}};
  EXPECT_EQ(line(json_of(toy)), R"({"mass":2.0,"owner":"Eve","price":3.0,"parts":[{"name":"wheel",)"
                                R"("mass":null}],"loud":false})");
  const Json schema = schema_of<Toy>();
  EXPECT_EQ(line(schema.at("required")), R"(["mass","price","parts","loud"])");
  EXPECT_EQ(line(property(schema, "price")), R"({"anyOf":[{"type":"number"},{"type":"null"}]})");
  EXPECT_EQ(line(property(schema, "loud")), R"({"type":"boolean"})");
  EXPECT_EQ(line(property(property(schema, "parts").at("items"), "mass")),
            R"({"anyOf":[{"type":"number"},{"type":"null"}],"description":"[kg]"})");
}

struct Shelf {
  std::vector<Toy> toys;
};

RowsOf<In<Toy, Shelf>> rows(Of<In<Toy, Shelf>>) {
  return {{"place", [](auto& toy) { return toy.i; }}, {"mass", &Toy::mass}, {"of", [](auto& toy) {
                                                                               return toy.whole.toys.size();
                                                                             }}};
}

TEST(ReportRows, AnItemKnowsItsPlaceInTheWhole) {
  const Shelf shelf{{Toy{.mass = 1}, Toy{.mass = 5}}};
  EXPECT_EQ(line(json_of(within(&Shelf::toys)(shelf))),
            R"([{"place":0,"mass":1.0,"of":2},{"place":1,"mass":5.0,"of":2}])");
}

struct Crate {
  std::string name;
  Part part;
};

RowsOf<Crate> rows(Of<Crate>) { return {{"crate", &Crate::name}, {"part", &Crate::part}}; }

TEST(ReportRows, ATableHasTheMembersAsColumns) {
  const std::vector<Crate> crates{{"a,b", {"wheel", 2}},
                                  {"c", {"axle", std::numeric_limits<double>::infinity()}}};
  EXPECT_EQ(csv_of(crates), "crate,name,mass\r\n\"a,b\",wheel,2\r\nc,axle,\r\n");
  EXPECT_EQ(csv_of(crates, {"crate"}), "name,mass\r\nwheel,2\r\naxle,\r\n");
  EXPECT_EQ(csv_of(std::vector<Crate>()), "crate,name,mass\r\n");
}

}  // namespace
}  // namespace qerr
