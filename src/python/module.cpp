#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>

#include "cli/shared.hpp"
#include "core/run_files.hpp"
#include "input/csv.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/write.hpp"

/// The module `qerr._qerr`: the commands of the program, run within the process of Python.
namespace {

namespace py = pybind11;
using Words = std::vector<std::string>;
using Column = py::array_t<double, py::array::forcecast>;

/// What a command gave.
struct Ran {
  int code = 0;
  std::map<std::string, std::string> reports;
  Words warnings;
  py::dict columns;
};

/// An array that owns its numbers.
py::array_t<double> array_of(std::vector<double> numbers) {
  auto* values = new std::vector<double>(std::move(numbers));
  const py::capsule owner(values, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  return py::array_t<double>(static_cast<py::ssize_t>(values->size()), values->data(), owner);
}

/// Runs a command line in a thread, so that this one can see Ctrl-C. One runs at a time: the files of a run
/// are those of the process.
/// @param formats  in which the report is wanted
/// @param log  the columns of a log, read where they are
/// @param columns  whether the figures of every configuration are wanted, as arrays
Ran run(const Words& words, const Words& formats, const std::vector<std::pair<std::string, Column>>& log,
        bool columns) {
  static std::mutex running;
  qerr::cli::Caller caller;
  caller.formats = formats;
  caller.wants_columns = columns;
  for (const auto& [name, values] : log) {
    if (values.ndim() != 1) throw py::value_error("column '" + name + "' must have one dimension");
    caller.log.push_back({name, values.data(), static_cast<std::size_t>(values.size()),
                          values.strides(0) / static_cast<py::ssize_t>(sizeof(double))});
  }
  Ran ran;
  std::exception_ptr failure;
  bool interrupted = false;
  {
    const py::gil_scoped_release released;
    const std::lock_guard one_at_a_time(running);
    std::mutex mutex;
    std::condition_variable ended;
    bool over = false;
    std::thread work([&] {
      qerr::cli::caller() = &caller;
      try {
        const qerr::RunFiles files;
        ran.code = qerr::cli::run_command_line(words);
      } catch (...) {
        failure = std::current_exception();
      }
      qerr::cli::caller() = nullptr;
      const std::lock_guard lock(mutex);
      over = true;
      ended.notify_one();
    });
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return over; })) {
      lock.unlock();
      if (!interrupted) {
        const py::gil_scoped_acquire held;
        interrupted = PyErr_CheckSignals() != 0;
        caller.stops = interrupted;
      }
      lock.lock();
    }
    lock.unlock();
    work.join();
  }
  if (interrupted) throw py::error_already_set();
  if (failure) std::rethrow_exception(failure);
  ran.reports = std::move(caller.reports);
  ran.warnings = std::move(caller.warnings);
  for (std::size_t i = 0; i < caller.columns.names.size(); ++i)
    ran.columns[caller.columns.names[i].c_str()] = array_of(std::move(caller.columns.values[i]));
  return ran;
}

py::list faults(const qerr::Error& e) {
  py::list all;
  for (const qerr::Fault& f : e.faults()) {
    py::dict one;
    one["file"] = f.place.file;
    one["line"] = f.place.line;
    one["column"] = f.place.column;
    one["key"] = f.key;
    one["rule"] = f.rule;
    one["found"] = f.found;
    one["remedy"] = f.remedy;
    all.append(one);
  }
  return all;
}

/// qerr.Error for what the program would print and end with.
void translate(std::exception_ptr failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const qerr::Error& e) {
    const py::object type = py::module_::import("qerr").attr("Error");
    PyErr_SetObject(type.ptr(), type(e.what(), faults(e), static_cast<int>(e.trouble())).ptr());
  }
}

/// The columns of a CSV file of numbers, such as a log, by their names; an empty cell is nan.
py::dict columns(const std::string& path) {
  qerr::CsvReader table(path, {.empty_cells = true});
  std::vector<std::size_t> all(table.header().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  table.choose(all);
  std::vector<std::vector<double>> numbers(all.size());
  for (std::vector<double> row(all.size()); table.next(row.data());)
    for (const std::size_t c : all) numbers[c].push_back(row[c]);
  py::dict arrays;
  for (const std::size_t c : all) arrays[table.header()[c].c_str()] = array_of(std::move(numbers[c]));
  return arrays;
}

const char* kind_name(qerr::cli::OptionKind kind) {
  using Kind = qerr::cli::OptionKind;
  switch (kind) {
    case Kind::flag:
      return "flag";
    case Kind::repeat:
    case Kind::list:
      return "repeat";
    case Kind::pair:
      return "pair";
    case Kind::optional:
      return "optional";
    case Kind::number:
      return "number";
    case Kind::whole:
      return "whole";
    case Kind::text:
      break;
  }
  return "text";
}

/// The options of a command: argument, kind and meaning, for its signature and docstring.
std::vector<std::array<std::string, 3>> options(const std::string& command) {
  std::vector<std::array<std::string, 3>> all;
  if (const qerr::cli::Command* row = qerr::cli::command_of(command))
    for (const qerr::cli::Option& option : row->options) {
      if (option.positional()) continue;
      std::string name = option.key();
      std::ranges::replace(name, '-', '_');
      all.push_back({name, kind_name(option.kind), std::string(option.meaning)});
    }
  return all;
}

}  // namespace

PYBIND11_MODULE(_qerr, m) {
  py::register_exception_translator(translate);
  m.attr("version") = std::string(qerr::version());
  py::class_<Ran>(m, "Ran")
      .def_readonly("code", &Ran::code)
      .def_readonly("reports", &Ran::reports)
      .def_readonly("warnings", &Ran::warnings)
      .def_readonly("columns", &Ran::columns);
  m.def("run", &run, py::arg("words"), py::arg("formats"), py::arg("log") = py::list(),
        py::arg("columns") = false);
  m.def("columns", &columns);
  m.def("options", &options);
  m.def("json_schema", &qerr::json_schema);
}
