#include <cmath>

#include "core/text.hpp"
#include "input/design_sections.hpp"

namespace qerr {

namespace {

/// The whole numbers of a range FROM..TO; empty for other text.
std::vector<Node> range_of(const Field& f) {
  const std::string& text = f.node->text;
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return {};
  const auto from = parse_number(text.substr(0, dots)), to = parse_number(text.substr(dots + 2));
  const auto whole = [](const std::optional<double>& v) { return v && *v == std::floor(*v); };
  if (!whole(from) || !whole(to))
    throw Error(f.fault("must be a range of whole numbers", "write it as 12..23, or list the values"));
  if (*to < *from) throw Error(f.fault("the range is empty", "write the smaller end first"));
  if (*to - *from >= static_cast<double>(most_options))
    throw Error(f.fault("has more than 10000 values", "list the values that can be bought"));
  std::vector<Node> values;
  for (double v = *from; v <= *to; ++v) {
    values.push_back(scalar_node(shortest(v)));
    values.back().place = f.node->place;
  }
  return values;
}

}  // namespace

std::vector<Node> values_of(const Field& f) {
  std::vector<Field> items{f};
  if (f.node->type == Node::Type::sequence) items = read_list(f);
  if (items.empty()) throw Error(f.fault("the list is empty", "give at least one value"));
  std::vector<Node> values;
  for (const Field& item : items) {
    if (item.node->type != Node::Type::scalar)
      throw Error(item.fault("must be a value or a range of whole numbers", "such as 12..23"));
    const std::vector<Node> range = range_of(item);
    if (range.empty())
      values.push_back(*item.node);
    else
      values.insert(values.end(), range.begin(), range.end());
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (values[i].text == values[k].text)
        throw Error({values[i].place, f.path, "duplicate value", qerr::quoted(values[i].text),
                     "keep one of the two"});
  return values;
}

double price_at(const Field& f) { return read_number(f, {.name = "price", .least = 0}); }

}  // namespace qerr
