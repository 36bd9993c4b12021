#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/lists.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

/// A kind of quantity as people call it: "an angle", "a speed", "a quantity in N m/rad".
std::string name_of(const Dimension&);

/// "give an angle in rad, mrad, deg, arcmin or arcsec".
std::string unit_remedy(const Dimension&);

/// Faults found so far: reading continues after a faulty section, so that one run reports all faults.
class Faults {
 public:
  /// Runs `read` and keeps the faults of an input error that it throws. @returns true if it threw none
  template <class Read>
  bool guard(Read read) {
    try {
      read();
      return true;
    } catch (const Error& e) {
      if (e.trouble() != Trouble::input) throw;
      all_.insert(all_.end(), e.faults().begin(), e.faults().end());
      return false;
    }
  }

  bool any() const { return !all_.empty(); }

  /// @throws Error (input) with all faults, if there are any
  void raise() const {
    if (any()) throw Error(all_);
  }

 private:
  std::vector<Fault> all_;
};

/// A value and the dotted path by which messages name it. Borrows the node, which must outlive it.
struct Field {
  const Node* node = nullptr;
  std::string path;

  Fault fault(std::string rule, std::string remedy) const {
    return {node->place, path, std::move(rule), described(*node), std::move(remedy)};
  }

  /// @throws Error (input) with that fault
  [[noreturn]] void refuse(std::string rule, std::string remedy) const {
    throw Error(fault(std::move(rule), std::move(remedy)));
  }

  [[noreturn]] void refuse_missing(std::string_view key, std::string remedy) const {
    throw Error(node->place, path_of(key), "missing key", "", std::move(remedy));
  }

  /// Of a key of this mapping, also of the whole spec, whose path is empty.
  std::string path_of(std::string_view key) const {
    return path.empty() ? std::string(key) : path + '.' + std::string(key);
  }
};

/// A number with an optional unit, in SI units.
/// @param coordinate  dimension of the joint coordinate, for rows with `Parameter::coordinate`
/// @throws Error (input) like all functions below, if the value is not of this kind
double read_number(const Field&, const Parameter&, Dimension coordinate = {});
std::string read_choice(const Field&, const Parameter&);

/// Warns of an angle beyond `turns` revolutions that is written without a unit: it is in rad, and was
/// probably meant in degrees. Values that are no such number are left alone.
void warn_of_degrees(const Field&, double turns, std::vector<std::string>& warnings);
std::string read_text_value(const Field&);
/// @param example  of such a list, for the message about another value
std::vector<Field> read_list(const Field&, const std::string& example = "[a, b, ...]");
std::vector<std::pair<Node::Key, Field>> read_map(const Field&);

/// Which of the names a mapping has at a key.
/// @param unknown  the rule that any other name breaks
std::size_t read_name(const Field& map, std::string_view key, const std::vector<std::string>& names,
                      const char* unknown);
/// The row of a list such as filter_families() that a mapping names at a key.
template <class Row>
const Row& read_member(const Field& map, std::string_view key, const std::vector<Row>& rows,
                       const char* unknown) {
  return rows[read_name(map, key, names_of(rows), unknown)];
}

bool has_row(const std::vector<Parameter>&, std::string_view key);

/// Warns of numbers without a unit that are larger than usual (`Parameter::usual`).
void warn_of_bare_numbers(const Field& map, const std::vector<Parameter>&, Dimension coordinate,
                          std::vector<std::string>& warnings);

/// A mapping whose keys have been checked against the rows of its format. Borrows the node of the field.
class Object {
 public:
  /// @throws Error (input) listing every unknown and every missing key
  Object(const Field&, const std::vector<Parameter>& format);

  bool has(std::string_view key) const { return field_.node->find(key) != nullptr; }
  Field at(std::string_view key) const;
  const Field& self() const { return field_; }

  /// The number at `key`, or the default of the row; empty if there is neither.
  std::optional<double> number(std::string_view key, Dimension coordinate = {}) const;
  std::string choice(std::string_view key) const;  ///< the first choice if the key is absent
  std::optional<std::string> text(std::string_view key) const;

  /// All numbers and choices that are given or have defaults, by name: the arguments of a row's functions.
  std::map<std::string, double> numbers(const std::vector<Parameter>&, Dimension coordinate = {}) const;
  std::map<std::string, std::string> choices(const std::vector<Parameter>&) const;

 private:
  const Parameter& row(std::string_view key) const;

  Field field_;
  std::vector<Parameter> format_;
};

/// Adds the fault of a key that a mapping does not have, with the habit behind it: a misspelling, a key of
/// another section, a missing space after the colon, a decimal comma, or entries that are not indented below
/// their section. Messages show twenty faults: what further keys may mean is not looked for.
void add_unknown_key(const Field& map, const Node::Entry&, const std::vector<std::string>& known,
                     std::vector<Fault>& faults);

}  // namespace qerr
