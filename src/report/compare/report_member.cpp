#include "report/compare/report_member.hpp"

#include "core/text.hpp"

namespace qerr {

namespace {

constexpr const char* written_anew = "write the report anew with --format json";

}  // namespace

ReportMember ReportMember::inner(const Json& value, const std::string& step) const {
  ReportMember member(value, *file_);
  member.path_ = path_ + (path_.empty() || step.starts_with('[') ? "" : ".") + step;
  return member;
}

Error ReportMember::fault(const std::string& rule, const std::string& found,
                          const std::string& remedy) const {
  return Error(Fault{{*file_}, path_, rule, found, remedy});
}

Error ReportMember::unlike(const std::string& wanted) const {
  const std::string found = value_->line();
  return fault("must be " + wanted, found.size() > 40 ? found.substr(0, 40) + "..." : found, written_anew);
}

std::optional<ReportMember> ReportMember::find(std::string_view name) const {
  const Json* value = value_->find(name);
  if (!value) return {};
  return inner(*value, std::string(name));
}

ReportMember ReportMember::at(std::string_view name) const {
  if (auto member = find(name)) return *member;
  throw fault("missing member '" + std::string(name) + "'", "", written_anew);
}

std::vector<ReportMember> ReportMember::items() const {
  if (!value_->items()) throw unlike("a list");
  std::vector<ReportMember> members;
  for (const Json& item : *value_->items())
    members.push_back(inner(item, '[' + std::to_string(members.size()) + ']'));
  return members;
}

std::vector<std::pair<std::string, ReportMember>> ReportMember::members() const {
  if (!value_->is_object()) throw unlike("an object");
  std::vector<std::pair<std::string, ReportMember>> list;
  for (const JsonMember& member : value_->members())
    list.emplace_back(member.name, inner(member.value, member.name));
  return list;
}

const std::string& ReportMember::text() const {
  if (!value_->text()) throw unlike("a text");
  return *value_->text();
}

bool ReportMember::boolean() const {
  const auto value = value_->boolean();
  if (!value) throw unlike("true or false");
  return *value;
}

double ReportMember::number() const {
  const auto value = value_->number();
  if (!value) throw unlike("a number");
  return *value + 0.0;  // -0 is 0
}

double ReportMember::number_or(double of_null) const { return is_null() ? of_null : number(); }

}  // namespace qerr
