#pragma once
/// The folder of a stick that is to get reports.

#include <cstdint>
#include <string_view>

namespace plumbline::inline hal {

/// A stick with this folder gets the reports of the last prints.
inline constexpr const char* kReportFolder = "plumbline-reports";
inline constexpr std::size_t kReportNameBytes = 64;

/// Letters, digits, '.', '-' and '_', at least one and fewer than kReportNameBytes, none of them hidden.
bool is_report_name(std::string_view name);

/// Copies a part of a file into a folder of a stick. Complete and durable when it returns 0; else nothing of it is left, or a file named
/// "unfinished" that the next copy replaces. Never overwrites another file and follows no link.
/// @param top   descriptor of the stick's top folder
/// @param name  is_report_name()
/// @param file  descriptor; `bytes` bytes from `from` on are copied
/// @returns errno: EEXIST if there is a file of that name, ENOENT if the stick has no such folder, ENOSPC if it is full
int copy_report(int top, std::string_view name, int file, std::uint64_t from, std::uint64_t bytes);

}  // namespace plumbline::inline hal
