#include <algorithm>
#include <set>
#include <unordered_map>

#include "core/lists.hpp"
#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/design_request.hpp"
#include "input/joint_entries.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

namespace {

struct CatalogueColumn {
  enum class Role { name, price, encoder, effect, description };
  Role role = Role::description;
  std::string key;     ///< of the encoder's entry; name of the effect
  std::string detail;  ///< the effect's parameter
  std::string unit;    ///< of cells without one
};

/// The kind that refuses a key because vendors mean different things by it; null if none does.
const EncoderKind* refusing_kind(const std::string& key) {
  for (const EncoderKind& kind : encoder_kinds()) {
    const std::vector<std::string> words = words_of(kind.ambiguous_keys);
    if (contains(words, key)) return &kind;
  }
  return nullptr;
}

/// The parameter that is the size of an effect: the only number that it requires; null if there are more.
const Parameter* size_of(const EffectKind& kind) {
  const Parameter* found = nullptr;
  for (const Parameter& row : kind.parameters) {
    if (!row.required) continue;
    if (found) return nullptr;
    found = &row;
  }
  return found;
}

CatalogueColumn effect_column(const std::string& name, const ColumnName& cell, const Place& place) {
  const std::size_t point = name.find('.');
  const EffectKind& kind = effect_kind(name.substr(0, point));
  CatalogueColumn column{CatalogueColumn::Role::effect, std::string(kind.name), {}, cell.unit};
  if (point == std::string::npos) {
    const Parameter* size = size_of(kind);
    if (!size)
      throw Error(place, name, "the effect has several parameters", qerr::quoted(name),
                  "name one a column: " + name + '.' + std::string(kind.parameters.front().name));
    column.detail = size->name;
    return column;
  }
  column.detail = name.substr(point + 1);
  const std::vector<std::string> known = names_of(kind.parameters);
  if (!contains(known, column.detail))
    throw Error(place, name, "the effect has no such parameter", qerr::quoted(column.detail),
                did_you_mean(column.detail, known));
  return column;
}

/// The known column that a header names in capitals, with blanks or hyphens, or with its unit in parentheses
/// or behind an underscore; "" if there is none.
std::string another_spelling(const std::string& name, const std::vector<std::string>& known) {
  std::string plain = lower_case(name.substr(0, name.find('(')));
  std::ranges::replace_if(
      plain, [](char c) { return c == ' ' || c == '-'; }, '_');
  while (plain.ends_with('_')) plain.pop_back();
  for (const std::string& word : known)
    if (plain == word) return word;
  const std::size_t last = plain.rfind('_');
  std::string why;
  if (last == std::string::npos || !parse_quantity("1 " + plain.substr(last + 1), why)) return "";
  plain.resize(last);
  return contains(known, plain) ? plain : "";
}

CatalogueColumn column_of(const std::string& header, const Place& place) {
  const ColumnName cell = column_name(header);
  const std::string& name = cell.name;
  using Role = CatalogueColumn::Role;
  if (name == "name") return {Role::name, {}, {}, {}};
  if (name == "price") return {Role::price, {}, {}, cell.unit};
  if (contains(encoder_keys(), name)) return {Role::encoder, name, {}, cell.unit};
  if (contains(names_of(effect_kinds()), name.substr(0, name.find('.'))))
    return effect_column(name, cell, place);
  if (const EncoderKind* kind = refusing_kind(name))
    throw Error(place, name, "is ambiguous: vendors use it for lines and for counts, 4 times as many",
                qerr::quoted(name), std::string(kind->ambiguous_remedy));
  std::vector<std::string> known = encoder_keys();
  known.insert(known.end(), {"name", "price"});
  for (const std::string& effect : names_of(effect_kinds())) known.push_back(effect);
  if (const std::string meant = another_spelling(name, known); !meant.empty())
    throw Error(place, name, "is not how this column is written", qerr::quoted(name),
                "write '" + meant + "', a unit in brackets behind it: '" + meant + " [unit]'");
  // A slip of the keyboard rarely hits the first letter; `mounting` is not meant to be `rounding`.
  if (const std::string near = nearest(name, known); !near.empty() && near.front() == name.front())
    throw Error(place, name, "unknown column, and nearly one that is known", qerr::quoted(name),
                "did you mean '" + near + "'? Name a column of descriptions differently");
  constexpr const char* of_speed[] = {"speed", "frequency", "count_rate", "rpm"};
  for (const char* word : of_speed)
    if (name.find(word) != std::string::npos && name.find("max") != std::string::npos)
      throw Error(place, name, "unknown column, and a limit of speed that would not be kept",
                  qerr::quoted(name),
                  "state it as max_frequency [kHz] of the signal periods, or as max_count_rate [kHz]: speed "
                  "in turns a second times counts a turn; name a column of descriptions differently");
  return {Role::description, {}, {}, {}};
}

/// A cell with its unit: its own, else that of the header.
Node cell_value(const std::string& text, const std::string& unit, const Place& place) {
  Node node = scalar_node(unit.empty() || !parse_number(text) ? text : text + ' ' + unit);
  node.place = place;
  return node;
}

Node mapping_at(const Place& place) {
  Node node = mapping_node({});
  node.place = place;
  return node;
}

void add_entry(Node& mapping, const std::string& key, Node value, const Place& place) {
  mapping.entries.push_back({{key, place}, std::move(value)});
}

double price_of(const std::string& text, const Place& place) {
  const auto price = parse_number(text);
  if (price && *price >= 0 && *price <= highest_price) return *price;
  throw Error(place, "price", "must be a number from 0 to 1e9", qerr::quoted(text),
              "write the number alone; its currency may stand in the header, price [EUR]");
}

void add_effect(CatalogueRow& row, const CatalogueColumn& column, Node value, const Place& place) {
  auto effect =
      std::ranges::find_if(row.effects, [&](const Node& e) { return e.find("type")->text == column.key; });
  if (effect == row.effects.end()) {
    effect = row.effects.insert(effect, mapping_at(place));
    add_entry(*effect, "type", cell_value(column.key, "", place), place);
  }
  add_entry(*effect, column.detail, std::move(value), place);
}

/// What a table that semicolons separate says of its numbers.
struct Decimals {
  bool commas = false;             ///< some have decimal commas
  std::vector<Fault> ambiguities;  ///< of numbers whose point may be that of thousands
};

/// `12,5` or `0,05 deg` in a table that semicolons separate: its numbers have decimal commas.
void read_decimal_commas(const std::vector<CatalogueColumn>& columns, std::vector<std::string>& cells,
                         const std::vector<Place>& places, Decimals& decimals) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    using Role = CatalogueColumn::Role;
    if (columns[i].role == Role::name || columns[i].role == Role::description) continue;
    if (may_be_thousands(cells[i])) decimals.ambiguities.push_back(ambiguous_point(places[i], "", cells[i]));
    if (replace_decimal_comma(cells[i])) decimals.commas = true;
  }
}

CatalogueRow row_of(const std::vector<CatalogueColumn>& columns, const std::vector<std::string>& cells,
                    const std::vector<Place>& places) {
  CatalogueRow row{{}, {}, mapping_at(places.front()), {}, places.front()};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const CatalogueColumn& column = columns[i];
    if (cells[i].empty()) continue;
    switch (column.role) {
      case CatalogueColumn::Role::name:
        row.name = cells[i];
        break;
      case CatalogueColumn::Role::price:
        row.price = price_of(cells[i], places[i]);
        break;
      case CatalogueColumn::Role::encoder:
        add_entry(row.entry, column.key, cell_value(cells[i], column.unit, places[i]), places[i]);
        break;
      case CatalogueColumn::Role::effect:
        add_effect(row, column, cell_value(cells[i], column.unit, places[i]), places[i]);
        break;
      case CatalogueColumn::Role::description:
        break;
    }
  }
  if (row.name.empty())
    throw Error(row.place, "name", "the row has no name", "", "give each row a name of its own");
  return row;
}

std::vector<CatalogueColumn> columns_of(const CsvReader& csv, Faults& faults) {
  std::vector<CatalogueColumn> columns(csv.header().size());
  std::set<std::string> seen;
  for (std::size_t i = 0; i < columns.size(); ++i)
    faults.guard([&] {
      columns[i] = column_of(csv.header()[i], csv.header_place(i));
      const std::string name = column_name(csv.header()[i]).name;
      if (!seen.insert(name).second)
        throw Error(csv.header_place(i), name, "duplicate column", qerr::quoted(name), "keep one of the two");
    });
  // A file of another kind may hold what is nobody's business: its first line is not repeated.
  const bool known = std::ranges::any_of(
      columns, [](const CatalogueColumn& c) { return c.role != CatalogueColumn::Role::description; });
  if (!seen.contains("name"))
    faults.guard([&] {
      throw Error(csv.header_place(0), "name", "the catalogue has no column of this name",
                  known ? list_of_names(csv.header()) : "", "add it: it names the rows in reports");
    });
  return columns;
}

}  // namespace

Catalogue read_catalogue(const std::string& path) {
  CsvReader csv(path, {.semicolons = true});
  name_input(path, "catalogue");
  Catalogue catalogue{csv.file(), {}, {}};
  Faults faults;
  const std::vector<CatalogueColumn> columns = columns_of(csv, faults);
  faults.raise();
  for (const CatalogueColumn& column : columns)
    if (column.role == CatalogueColumn::Role::price) catalogue.price_unit = column.unit;
  std::vector<std::string> cells;
  std::vector<Place> places;
  std::unordered_map<std::string, int> lines;
  Decimals decimals;
  while (csv.next_texts(cells, places))
    faults.guard([&] {
      if (csv.separator() == ';') read_decimal_commas(columns, cells, places, decimals);
      CatalogueRow row = row_of(columns, cells, places);
      const auto [other, is_new] = lines.emplace(row.name, row.place.line);
      if (!is_new)
        throw Error(row.place, "name", "duplicate name, as in line " + std::to_string(other->second),
                    qerr::quoted(row.name), "give each row a name of its own");
      catalogue.rows.push_back(std::move(row));
    });
  faults.raise();
  if (decimals.commas && !decimals.ambiguities.empty()) throw Error(decimals.ambiguities);
  if (catalogue.rows.empty())
    throw Error({csv.file(), 1, 1}, "", "the catalogue has no rows", "", "add a row for each encoder");
  return catalogue;
}

Node on_joint(const Node& effect, const std::string& joint) {
  Node node = effect;
  node.entries.insert(node.entries.begin() + 1,
                      {{"joint", effect.place}, cell_value(joint, "", effect.place)});
  return node;
}

}  // namespace qerr
