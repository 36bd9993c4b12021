#include "input/log_table.hpp"

#include "input/joined_log.hpp"

namespace qerr {

LogTable::LogTable(const LogFiles& files, const CsvLimits& limits) {
  std::vector<std::unique_ptr<CsvReader>> tables;
  for (const std::string& path : files.paths) {
    tables.push_back(std::make_unique<CsvReader>(path, limits));
    file_ += (file_.empty() ? "" : ", ") + tables.back()->file();
  }
  if (tables.size() == 1 && !files.hold && !is_long_format(*tables[0])) {
    streamed_ = std::move(tables[0]);
    return;
  }
  joined_ = std::make_unique<JoinedLog>(files.hold);
  for (auto& table : tables) {
    joined_->add(*table, tables.size() > 1);
    table.reset();
  }
}

LogTable::~LogTable() = default;

const std::vector<std::string>& LogTable::header() const {
  return streamed_ ? streamed_->header() : joined_->header();
}
Place LogTable::header_place(std::size_t column) const {
  return streamed_ ? streamed_->header_place(column) : joined_->header_place(column);
}
void LogTable::choose(const std::vector<std::size_t>& columns) {
  streamed_ ? streamed_->choose(columns) : joined_->choose(columns);
}
bool LogTable::next(double* values, std::ptrdiff_t stride) {
  return streamed_ ? streamed_->next(values, stride) : joined_->next(values, stride);
}
int LogTable::line() const { return streamed_ ? streamed_->line() : 0; }
Place LogTable::place(std::size_t chosen) const {
  return streamed_ ? streamed_->place(chosen) : joined_->place(chosen);
}
std::string LogTable::text(std::size_t chosen) const {
  return streamed_ ? streamed_->text(chosen) : joined_->text(chosen);
}
DecimalText LogTable::written(std::size_t chosen) const {
  return streamed_ ? streamed_->written(chosen) : joined_->written(chosen);
}
std::uint64_t LogTable::position() const { return streamed_ ? streamed_->source().position() : 0; }
std::uint64_t LogTable::size() const { return streamed_ ? streamed_->source().size() : 0; }
std::vector<std::string> LogTable::warnings() const {
  return joined_ ? joined_->warnings() : std::vector<std::string>{};
}

}  // namespace qerr
