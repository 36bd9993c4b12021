#include "report/diagnosis/sentences.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string label(const Cause& c) {
  const double order = c.effect.number_or("order", 0);
  return c.effect.type + (order > 0 && order != 1 ? " (order " + significant(order, 4) + ")" : "") + " of " +
         shown(c.effect.joint);
}

namespace {

/// Names, at most four to keep the sentence readable.
std::string few_listed(std::vector<std::string> names) {
  constexpr std::size_t most = 4;
  if (names.size() > most) {
    const std::string more = std::to_string(names.size() - most + 1) + " more";
    names.resize(most - 1);
    names.push_back(more);
  }
  return listed(names);
}

std::string listed_causes(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const Cause& c : d.causes) names.push_back(label(c));
  return few_listed(std::move(names));
}

/// "; not judged: elbow and tip"; "" if all is judged.
std::string unjudged_words(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const std::string& place : d.unjudged) names.push_back(shown(place));
  return names.empty() ? "" : "; not judged: " + few_listed(std::move(names));
}

std::string cause_or_alternative(const Diagnosis& d) {
  if (d.causes.size() != 1 || d.alternatives.size() != 1)
    return listed_causes(d) + ", or other causes (below)";
  return d.causes.front().effect.type + " or " + d.alternatives.front().effect + " of " +
         shown(d.causes.front().effect.joint);
}

std::string unidentified_places(const Diagnosis& d) {
  std::vector<std::string> places;
  for (const Unidentified& u : d.unexplained)
    if (std::find(places.begin(), places.end(), shown(u.joint)) == places.end())
      places.push_back(shown(u.joint));
  return listed(places);
}

/// Whether all that remains has one shape, at one joint.
bool has_one_shape(const Diagnosis& d) {
  return d.unexplained.size() == 1 && d.unexplained.front().shape != Shape::unknown;
}

}  // namespace

std::string verdict_title(const Diagnosis& d) {
  std::string word(name(d.verdict));
  if (d.verdict == Verdict::nothing_wrong && !is_faultless(d)) {
    std::vector<std::string> faults;
    for (const DataKind kind : record_faults(d)) faults.emplace_back(name(kind));
    const std::string readings = faults.empty() ? "" : listed(faults) + " readings";
    const std::string part = d.unjudged.empty() ? "" : "not all judged";
    word += ", but " + readings + (faults.empty() || part.empty() ? "" : ", and ") + part;
  }
  std::replace(word.begin(), word.end(), '_', ' ');
  std::transform(word.begin(), word.end(), word.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return word;
}

namespace {

std::string words_of_verdict(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  switch (d.verdict) {
    case Verdict::nothing_wrong:
      return std::string(record_faults(d).empty() ? "" : "apart from them ") +
             "the log agrees with the model, its quantization and the noise of the reference";
    case Verdict::explained:
      return listed_causes(d);
    case Verdict::partly_explained:
      if (has_one_shape(d))
        return listed_causes(d) + "; there remains " + shape_words(r.spec, d.unexplained.front()) + " at " +
               unidentified_places(d);
      return listed_causes(d) + "; significant, unidentified errors at " + unidentified_places(d);
    case Verdict::ambiguous:
      return cause_or_alternative(d) + ": not distinguishable in this log";
    case Verdict::unexplained:
      if (has_one_shape(d))
        return unidentified_places(d) + " has " + shape_words(r.spec, d.unexplained.front()) +
               ", which no effect of the catalogue explains";
      return "significant errors at " + unidentified_places(d) + " that no effect of the catalogue explains";
    case Verdict::cannot_judge:
      return d.reason.empty() ? "the log has no reference sensor to compare the encoders with"
                              : escaped(d.reason);
  }
  return "";
}

}  // namespace

std::string verdict_words(const DiagnosisReport& r) {
  const bool judged = r.diagnosis.verdict != Verdict::cannot_judge;
  return words_of_verdict(r) + (judged ? unjudged_words(r.diagnosis) : "");
}

}  // namespace qerr
