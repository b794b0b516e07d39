#pragma once
/// Files that a slicer has written for other printers, known by the endings of their names.

#include <array>
#include <string_view>

#include "slicer/reader/stream/words.hpp"

namespace plumbline {

struct ForeignFormat {
  std::string_view ending;  ///< in lower case
  const char* program;      ///< that writes it
  const char* what;         ///< "is sliced for another printer"
  const char* advice;
};

namespace foreign {
inline constexpr const char* kSliced = "is sliced for another printer";
inline constexpr const char* kExport = "export it as .sl1";
inline constexpr const char* kProject = "is a project";
inline constexpr const char* kMesh = "export its mesh as STL";
inline constexpr const char* kFilament = "is sliced for a filament printer";
inline constexpr const char* kPhoton = "Photon Workshop";
}  // namespace foreign

inline constexpr auto kForeignFormats = std::to_array<ForeignFormat>({
    {".ctb", "Chitubox", foreign::kSliced, foreign::kExport},
    {".cbddlp", "Chitubox", foreign::kSliced, foreign::kExport},
    {".phz", "Chitubox", foreign::kSliced, foreign::kExport},
    {".fdg", "Voxelprint", foreign::kSliced, foreign::kExport},
    {".goo", "Elegoo", foreign::kSliced, foreign::kExport},
    {".prz", "Phrozen", foreign::kSliced, foreign::kExport},
    {".photon", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".photons", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pws", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pw0", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwx", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwmo", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwma", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwms", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwmx", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwmb", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pwsq", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pmsq", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pmx2", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm3", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm3m", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm3n", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm3r", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm4n", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm4u", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm5", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".pm5s", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".px6s", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".dlp", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".dl2p", foreign::kPhoton, foreign::kSliced, foreign::kExport},
    {".cxdlp", "Creality", foreign::kSliced, foreign::kExport},
    {".cxdlpv4", "Creality", foreign::kSliced, foreign::kExport},
    {".lgs", "Longer", foreign::kSliced, foreign::kExport},
    {".lgs30", "Longer", foreign::kSliced, foreign::kExport},
    {".lgs120", "Longer", foreign::kSliced, foreign::kExport},
    {".lgs4k", "Longer", foreign::kSliced, foreign::kExport},
    {".zcode", "Uniz", foreign::kSliced, foreign::kExport},
    {".zcodex", "Z-Suite", foreign::kSliced, foreign::kExport},
    {".cws", "Creation Workshop", foreign::kSliced, foreign::kExport},
    {".nanodlp", "NanoDLP", foreign::kSliced, foreign::kExport},
    {".svgx", "FlashPrint", foreign::kSliced, foreign::kExport},
    {".osf", "Vlare", foreign::kSliced, foreign::kExport},
    {".osla", "UVtools", foreign::kSliced, foreign::kExport},
    {".mdlp", "Makerbase", foreign::kSliced, foreign::kExport},
    {".gr1", "GR Workshop", foreign::kSliced, foreign::kExport},
    {".sl1_svg", "PrusaSlicer", foreign::kSliced, foreign::kExport},
    {".lys", "Lychee Slicer", foreign::kProject, foreign::kMesh},
    {".chitubox", "Chitubox", foreign::kProject, foreign::kMesh},
    {".form", "PreForm", foreign::kProject, foreign::kMesh},
    {".gcode", "G-code", foreign::kFilament, foreign::kMesh},
    {".bgcode", "G-code", foreign::kFilament, foreign::kMesh},
});

/// @returns null: the name has none of these endings
inline const ForeignFormat* foreign_format(std::string_view name) {
  for (const ForeignFormat& format : kForeignFormats) {
    if (has_ending(name, format.ending)) return &format;
  }
  return nullptr;
}

}  // namespace plumbline
