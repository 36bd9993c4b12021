#include "report/diagnosis/diagnosis_words.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string shown(const std::string& name) { return escaped(name, 60); }

std::string label(const Cause& c) {
  const double order = c.effect.number_or("order", 0);
  return c.effect.type + (order > 0 && order != 1 ? " (order " + significant(order, 4) + ")" : "") + " of " +
         shown(c.effect.joint);
}

namespace {

/// "a, b and c".
std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

/// At most four, as a sentence is to be read.
std::string named_causes(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const Cause& c : d.causes) names.push_back(label(c));
  constexpr std::size_t most = 4;
  if (names.size() > most) {
    const std::string more = std::to_string(names.size() - most + 1) + " more";
    names.resize(most - 1);
    names.push_back(more);
  }
  return listed(names);
}

std::string or_instead(const Diagnosis& d) {
  if (d.causes.size() != 1 || d.alternatives.size() != 1)
    return named_causes(d) + ", or other causes (below)";
  return d.causes.front().effect.type + " or " + d.alternatives.front().effect + " of " +
         shown(d.causes.front().effect.joint);
}

std::string unnamed_places(const Diagnosis& d) {
  std::vector<std::string> places;
  for (const Unidentified& u : d.unexplained)
    if (std::find(places.begin(), places.end(), shown(u.joint)) == places.end())
      places.push_back(shown(u.joint));
  return listed(places);
}

}  // namespace

std::string verdict_words(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::nothing_wrong:
      return "the log is what the model says, with its quantization and the reference's noise";
    case Verdict::explained:
      return named_causes(d);
    case Verdict::partly_explained:
      return named_causes(d) + "; at " + unnamed_places(d) + " something real has no name";
    case Verdict::ambiguous:
      return or_instead(d) + ": this log cannot tell them apart";
    case Verdict::unexplained:
      return "something real at " + unnamed_places(d) + " has no name in the catalogue";
    case Verdict::cannot_judge:
      return d.reason.empty() ? "the log has no better sensor to hold the encoders against"
                              : escaped(d.reason);
  }
  return "";
}

}  // namespace qerr
