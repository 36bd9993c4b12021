#pragma once

#include <algorithm>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace qerr {

template <class Items, class Item>
bool contains(const Items& items, const Item& item) {
  return std::find(std::begin(items), std::end(items), item) != std::end(items);
}

/// Appends an item that the list does not have yet. @returns whether it has none
template <class Item>
bool add_once(std::vector<Item>& list, const std::type_identity_t<Item>& item) {
  if (contains(list, item)) return false;
  list.push_back(item);
  return true;
}

/// Appends the items of another list.
template <class Item>
void append(std::vector<Item>& to, std::vector<Item> items) {
  to.insert(to.end(), std::make_move_iterator(items.begin()), std::make_move_iterator(items.end()));
}

/// The first row of this name; null if there is none.
template <class Rows>
auto* find_named(Rows& rows, std::string_view name) {
  for (auto& row : rows)
    if (row.name == name) return &row;
  return decltype(&*std::begin(rows)){};
}

/// The names of rows, such as those of a family.
template <class Rows>
std::vector<std::string> names_of(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  return names;
}

/// `a, b, c`. @param text  of an item
template <class Items, class Text = std::identity>
std::string joined(const Items& items, std::string_view separator = ", ", const Text& text = {}) {
  std::string out;
  bool first = true;
  for (const auto& item : items) {
    if (!std::exchange(first, false)) out += separator;
    out += std::invoke(text, item);
  }
  return out;
}

}  // namespace qerr
