#include <algorithm>
#include <map>

#include "core/lists.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/catalogue.hpp"
#include "input/design_request.hpp"
#include "input/joint_entries.hpp"
#include "input/spec_format.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

namespace {

/// Reads the options of one entry of `design.encoders`.
class OptionReader {
 public:
  OptionReader(const Field& f, const std::string& folder, bool priced)
      : field_(f), folder_(folder), priced_(priced) {}

  std::vector<EncoderOption> read(std::string& price_unit) {
    check_keys();
    const Node* const catalogue = field_.node->find("catalogue");
    std::vector<EncoderOption> options =
        catalogue ? of_catalogue({catalogue, field_.path + ".catalogue"}, price_unit)
                  : std::vector<EncoderOption>{{"", empty_entry(), {}, 0, 0}};
    for (const Node::Entry& entry : field_.node->entries)
      if (is_encoder_key(entry.key.name)) options = crossed(options, entry);
    if (!catalogue) {
      encoder_kind_of({&options.front().entry, field_.path});  // states exactly one
      set_prices(options);
    }
    return options;
  }

 private:
  Node empty_entry() const {
    Node node = mapping_node({});
    node.place = field_.node->place;
    return node;
  }

  Field at(const std::string& key) const { return {field_.node->find(key), field_.path_of(key)}; }

  void check_keys() const {
    if (field_.node->type != Node::Type::mapping)
      field_.refuse("must be a mapping", "write {catalogue: FILE.csv} or {bits: 12..23}");
    std::vector<std::string> known = encoder_keys();
    known.insert(known.end(), {"catalogue", "price", "gear_price"});
    for (const Node::Entry& entry : field_.node->entries)
      if (!contains(known, entry.key.name))
        throw Error(entry.key.place, field_.path_of(entry.key.name), "unknown key",
                    qerr::quoted(entry.key.name), did_you_mean(entry.key.name, known));
    if (field_.node->find("catalogue") && field_.node->find("price"))
      at("price").refuse("the catalogue has the prices", "remove price");
    if (field_.node->find("gear_price") && !field_.node->find("gear_ratio"))
      at("gear_price").refuse("is the price of a gear ratio, and there is none", "add gear_ratio");
  }

  std::vector<EncoderOption> of_catalogue(const Field& f, std::string& price_unit) const {
    const std::string path = read_text_value(f);
    const std::string full = folder_.empty() || path.starts_with('/') ? path : folder_ + '/' + path;
    Catalogue catalogue;
    read_named_file(f, full, [&](const std::string& file) { catalogue = read_catalogue(file); });
    if (price_unit.empty()) price_unit = catalogue.price_unit;
    if (price_unit != catalogue.price_unit && !catalogue.price_unit.empty())
      f.refuse("its prices are in " + catalogue.price_unit + ", those of another catalogue in " + price_unit,
               "convert one of them");
    std::vector<EncoderOption> options;
    std::vector<Fault> faults;
    for (const CatalogueRow& row : catalogue.rows) {
      if (priced_ && !row.price)
        faults.push_back({row.place, "price", "the price of " + qerr::quoted(row.name) + " is missing", "",
                          "add it, remove the row, or write 'minimize: resolution', which needs no prices"});
      options.push_back({row.name, row.entry, row.effects, row.price, 0});
    }
    if (!faults.empty()) throw Error(faults);
    return options;
  }

  std::vector<EncoderOption> crossed(const std::vector<EncoderOption>& options,
                                     const Node::Entry& entry) const {
    const std::string& key = entry.key.name;
    const Field f = at(key);
    const std::vector<Node> values = values_of(f);
    const std::vector<double> prices =
        key == "gear_ratio" ? gear_prices(values.size()) : std::vector<double>{};
    if (options.size() * values.size() > most_options)
      field_.refuse("gives more than 10000 options", "list the ones that can be bought");
    std::vector<EncoderOption> all;
    for (const EncoderOption& option : options) {
      if (option.entry.find(key)) {
        // Of a row that states its own, a price of the value here would be another one's.
        if (!prices.empty())
          f.refuse("the catalogue states it for " + qerr::quoted(option.name),
                   "remove gear_price here, or the column from the catalogue");
        all.push_back(option);
        continue;
      }
      for (std::size_t i = 0; i < values.size(); ++i) {
        EncoderOption& added = all.emplace_back(option);
        added.entry.entries.push_back({entry.key, values[i]});
        if (!prices.empty() && added.price) *added.price += prices[i];
        if (values.size() > 1 || (option.name.empty() && field_.node->entries.size() == 1))
          added.name += (added.name.empty() ? "" : ", ") + key + ' ' + values[i].text;
      }
    }
    return all;
  }

  std::vector<double> gear_prices(std::size_t ratios) const {
    if (!field_.node->find("gear_price")) return {};
    const Field f = at("gear_price");
    if (f.node->type == Node::Type::scalar) return std::vector<double>(ratios, price_at(f));
    std::vector<double> prices;
    for (const Field& item : read_list(f)) prices.push_back(price_at(item));
    if (prices.size() != ratios)
      f.refuse("must be as many as the gear ratios, " + std::to_string(ratios),
               "give one price for each gear ratio, in their order");
    return prices;
  }

  /// `price: {fixed: 20, per_bit: 3}`, or a list with one price for each option; else 1 a bit.
  void set_prices(std::vector<EncoderOption>& options) const {
    for (EncoderOption& option : options) {
      if (option.name.empty()) option.name = "as stated";
      option.price_per_bit = 1;
    }
    if (!field_.node->find("price")) return;
    const Field f = at("price");
    if (f.node->type == Node::Type::sequence) return set_listed_prices(f, options);
    if (f.node->type != Node::Type::mapping)
      f.refuse("is ambiguous: of each, or of a bit?",
               "write {per_bit: 2}, {fixed: 50}, both, or a list with one price for each value");
    const Object o(f, {key::number("fixed", "of each").otherwise(0.0).from(0),
                       key::number("per_bit", "of a bit").otherwise(0.0).from(0)});
    for (EncoderOption& option : options) {
      *option.price += *o.number("fixed");
      option.price_per_bit = *o.number("per_bit");
    }
  }

  void set_listed_prices(const Field& f, std::vector<EncoderOption>& options) const {
    const std::vector<Field> prices = read_list(f);
    std::size_t lists = 0;
    const Node::Entry* list = nullptr;
    for (const Node::Entry& entry : field_.node->entries)
      if (is_encoder_key(entry.key.name) && entry.key.name != "gear_ratio" &&
          values_of(at(entry.key.name)).size() > 1) {
        ++lists;
        list = &entry;
      }
    const std::size_t wanted = list ? values_of(at(list->key.name)).size() : 1;
    if (lists > 1 || prices.size() != wanted)
      f.refuse(lists > 1 ? "several keys have several values: of which are these the prices?"
                         : "must have one price for each value, " + std::to_string(wanted),
               "or write {fixed: 50, per_bit: 2}, or a catalogue");
    for (EncoderOption& option : options) {
      std::size_t index = 0;
      if (list) {
        const std::vector<Node> values = values_of(at(list->key.name));
        while (values[index].text != option.entry.find(list->key.name)->text) ++index;
      }
      *option.price += price_at(prices[index]);
      option.price_per_bit = 0;
    }
  }

  Field field_;
  std::string folder_;
  bool priced_;
};

}  // namespace

void read_design_encoders(const Field& f, const std::string& folder, const RobotModel& robot, bool priced,
                          Spec& spec, DesignRequest& request, Faults& faults) {
  if (read_map(f).empty())
    f.refuse("names no joint", "write '*': {bits: 12..23} for all, or leave the section out");
  const std::vector<JointEntry> entries = joint_entries(f, robot, spec, faults);
  std::map<std::string, std::optional<std::vector<EncoderOption>>> read;  // by the entry's path
  for (std::size_t j = 0; j < entries.size(); ++j) {
    if (!entries[j].given()) continue;
    const Field& entry = entries[j].holding();
    if (!read.contains(entry.path)) {
      auto& options = read[entry.path];
      faults.guard([&] { options = OptionReader(entry, folder, priced).read(request.price_unit); });
    }
    if (const auto& options = read[entry.path]) request.encoders.push_back({j, *options});
  }
}

}  // namespace qerr
