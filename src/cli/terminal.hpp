#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "cli/command.hpp"
#include "qerr/report/write.hpp"

/// What depends on the terminal: colours, width, progress.
namespace qerr::cli {

/// Colours as --color says, the width of lines (COLUMNS, else the terminal's, else 80), and pictures in ASCII
/// unless the locale is UTF-8.
/// @param on_standard_output  whether the text goes there; a file has no colours unless they are asked for
Style terminal_style(const Values&, bool on_standard_output = true);

/// The width of messages on standard error; 0 where they are not for a terminal and each has one line.
std::size_t message_width();

/// Shows on a terminal's standard error, at most ten times a second, the part that is done, how much is done
/// in a second and the remaining time; nothing elsewhere, and nothing with --quiet.
/// @param noun  what is counted: `configurations`
std::function<void(std::uint64_t done, std::uint64_t total)> progress(const Values&,
                                                                      std::string_view noun = "");

/// Shows the progress of searches whose number is not known, as `progress` does: which one it is, and how
/// much of the work after which it ends at the latest.
std::function<void(std::size_t search, double part)> search_progress(const Values&);

/// What Ctrl-C leaves on a terminal, in a line of its own: how to go on, if a command has said so. Allocates
/// nothing.
std::string_view interrupt_message() noexcept;
void say_on_interrupt(const std::string& how_to_go_on);

/// `12 s`, `3 min 20 s`, `2 h 5 min`, `12 days`.
std::string duration(double seconds);

/// Removes the line of the progress, if there is one, before something else is printed.
void clear_progress();

/// A message on standard error, below the progress.
void print_error(const std::string& text);

}  // namespace qerr::cli
