#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "input/yaml_tree.hpp"
#include "qerr/core/parameter.hpp"

namespace qerr {

/// Faults found so far: reading goes on after a faulty section, so that one run shows them all.
class Faults {
 public:
  /// Runs `read`; what it throws as bad input is kept. @returns true when nothing was wrong
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

  /// Throws everything that was kept, if anything was.
  void raise() const {
    if (any()) throw Error(all_);
  }

 private:
  std::vector<Fault> all_;
};

/// A value, its place and the dotted path by which messages name it.
struct Field {
  const Node* node = nullptr;
  std::string path;

  Fault fault(std::string rule, std::string remedy) const {
    return {node->place, path, std::move(rule), described(*node), std::move(remedy)};
  }
};

/// A number with a unit, in SI. @param coordinate  the dimension a joint coordinate has here, when the row
/// says so
double read_number(const Field&, const Parameter&, Dimension coordinate = {});
std::string read_choice(const Field&, const Parameter&);
bool read_boolean(const Field&);
std::string read_text_value(const Field&);
std::vector<Field> read_list(const Field&);
std::vector<std::pair<Node::Key, Field>> read_map(const Field&);

/// A mapping that has been held against the rows of its format: known keys, required keys.
class Object {
 public:
  /// @throws Error (input) listing every unknown and every missing key
  Object(const Field&, const std::vector<Parameter>& format);

  bool has(std::string_view key) const { return field_.node->find(key) != nullptr; }
  Field at(std::string_view key) const;
  const Field& self() const { return field_; }

  /// The number at `key`, or the row's default; empty when there is neither.
  std::optional<double> number(std::string_view key, Dimension coordinate = {}) const;
  std::string choice(std::string_view key) const;  ///< the first choice when the key is absent
  std::optional<std::string> text(std::string_view key) const;

  /// All numbers and choices that are given or have defaults, by name: what a family's row function reads.
  std::map<std::string, double> numbers(const std::vector<Parameter>&, Dimension coordinate = {}) const;
  std::map<std::string, std::string> choices(const std::vector<Parameter>&) const;

 private:
  const Parameter& row(std::string_view key) const;

  Field field_;
  std::vector<Parameter> format_;
};

}  // namespace qerr
