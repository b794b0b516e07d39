#pragma once

#include <span>
#include <string_view>

namespace plumbline::firmware::inline page {

/// A file of web/, in the program.
struct PageFile {
  std::string_view path;  ///< "/", "/page.css", ...
  const char* type;
  std::string_view text;
  std::string_view packed;  ///< the text by gzip
};

std::span<const PageFile> page_files();

}  // namespace plumbline::firmware::inline page
