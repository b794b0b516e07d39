#include "slicer/reader/formats/foreign_formats.hpp"

#include <algorithm>
#include <array>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::inline slicer {
namespace {

using std::string_view_literals::operator""sv;

constexpr ForeignKind kSliced = {"is sliced for another printer", "export it as .sl1", ToldCode::kForeignPrint};
constexpr ForeignKind kFilament = {"is sliced for a filament printer", "export its mesh as STL",
                                   ToldCode::kForeignFilament};
constexpr ForeignKind kProject = {"is a project", "export its mesh as STL", ToldCode::kForeignProject};
constexpr ForeignKind kCad = {"is a CAD model", "export it as STL or 3MF", ToldCode::kForeignCad};
constexpr ForeignKind kModel = {"is a model that is not read", "export the mesh as STL, OBJ, PLY, OFF or 3MF",
                                ToldCode::kForeignModel};
constexpr ForeignKind kScan = {"is a scan that is not read", "export its points as E57, PLY or LAS",
                               ToldCode::kForeignScan};
constexpr ForeignKind kLaz = {"is a compressed scan", "save it as LAS, with laszip or CloudCompare", ToldCode::kLaz};
constexpr ForeignKind kSplats = {"is a scan that is not read", "export it as SPZ or PLY", ToldCode::kForeignSplats};
constexpr ForeignKind kPacked = {"is packed", "unpack it and give the scan inside", ToldCode::kPacked};
constexpr ForeignKind kPicture = {"is a picture", "give a scan, a mesh or a print that is sliced", ToldCode::kPicture};

constexpr ForeignFormat kFormats[] = {
    {".ctb .cbddlp .phz", "Chitubox", kSliced},
    {".fdg", "Voxelab", kSliced},
    {".goo", "Elegoo", kSliced},
    {".prz", "Phrozen", kSliced},
    {".jxs", "UniFormation", kSliced},
    {".photon .photons .pws .pw0 .pwx .pwmo .pwma .pwms .pwmx .pwmb .pwsq .pwsz .pwc .pmsq .pmx2 .pm3 .pm3m .pm3n "
     ".pm3r .pm4n .pm4u .pm5 .pm5s .m5sp .pm7 .pm7m .pp1 .pp1m .px6s .dlp .dl2p",
     "Photon Workshop", kSliced},
    {".cxdlp .cxdlpv4", "Creality", kSliced},
    {".lgs .lgs30 .lgs120 .lgs4k", "Longer", kSliced},
    {".zcode", "Uniz", kSliced},
    {".zcodex", "Z-Suite", kSliced},
    {".svgx", "FlashPrint", kSliced},
    {".osf", "Vlare", kSliced},
    {".osla", "UVtools", kSliced},
    {".mdlp", "Makerbase", kSliced},
    {".gr1", "GR Workshop", kSliced},
    {".vdt", "Voxeldance", kSliced},
    {".qdt", "Emake3D", kSliced},
    {".n4 .n7", "Anet", kSliced},
    {".sl1_svg", "PrusaSlicer", kSliced},
    {".lys", "Lychee Slicer", kProject},
    {".chitubox", "Chitubox", kProject},
    {".form", "PreForm", kProject},
    {".fcstd", "FreeCAD", kProject},
    {".f3d .f3z", "Fusion", kProject},
    {".scad", "OpenSCAD", kProject},
    {".blend", "Blender", kProject},
    {".c4d", "Cinema 4D", kProject},
    {".max", "3ds Max", kProject},
    {".ma .mb", "Maya", kProject},
    {".ztl .zpr", "ZBrush", kProject},
    {".gcode .bgcode", "G-code", kFilament},
    {".step .stp .p21 .stpz", "STEP", kCad},
    {".iges .igs", "IGES", kCad},
    {".ifc", "IFC", kCad},
    {".dxf", "DXF", kCad},
    {".dwg", "DWG", kCad},
    {".sldprt .sldasm .slddrw", "SolidWorks", kCad},
    {".ipt .iam", "Inventor", kCad},
    {".prt", "NX or Creo", kCad},
    {".par .psm", "Solid Edge", kCad},
    {".catpart .catproduct .cgr", "CATIA", kCad},
    {".x_t .x_b .xmt_txt .xmt_bin", "Parasolid", kCad},
    {".sat .sab", "ACIS", kCad},
    {".jt", "JT", kCad},
    {".brep .brp", "Open CASCADE", kCad},
    {".3dm", "Rhino", kCad},
    {".skp", "SketchUp", kCad},
    {".dgn", "MicroStation", kCad},
    {".fbx", "FBX", kModel},
    {".gltf .glb", "glTF", kModel},
    {".dae .zae", "COLLADA", kModel},
    {".amf", "AMF", kModel},
    {".3ds .ase", "3D Studio", kModel},
    {".x", "DirectX", kModel},
    {".ac", "AC3D", kModel},
    {".cob", "Caligari", kModel},
    {".lwo .lxo", "LightWave", kModel},
    {".usd .usda .usdc .usdz", "USD", kModel},
    {".wrl .vrml", "VRML", kModel},
    {".x3d .x3dv .x3db", "X3D", kModel},
    {".u3d", "U3D", kModel},
    {".vtk .vtp .vtu", "VTK", kModel},
    {".msh", "Gmsh", kModel},
    {".ctm", "OpenCTM", kModel},
    {".drc", "Draco", kModel},
    {".abc", "Alembic", kModel},
    {".fls .fws .lsproj", "FARO", kScan},
    {".zfs", "Zoller + Froehlich", kScan},
    {".rcp .rcs", "ReCap", kScan},
    {".rxp", "RIEGL", kScan},
    {".imp", "Cyclone", kScan},
    {".psx .psz", "Metashape", kScan},
    {".rcproj", "RealityCapture", kScan},
    {".sproj", "Artec Studio", kScan},
    {".laz", "LAZ", kLaz},
    {".splat .ksplat .sog", "Gaussian splats", kSplats},
    {".7z .rar .gz .tgz .tar .xz .bz2 .zst", "7z, gzip or the like", kPacked},
    {".jpg", "JPEG", kPicture},
    {".png", "PNG", kPicture},
    {".gif", "GIF", kPicture},
    {".bmp", "BMP", kPicture},
    {".tif", "TIFF", kPicture},
    {".webp", "WebP", kPicture},
    {".heic", "HEIC", kPicture},
    {".pdf", "PDF", kPicture},
};

struct Signature {
  std::string_view bytes;
  std::string_view ending;  ///< of its row in kFormats
};
/// Of those that zip files are, names tell more. The sliced ones are those of UVtools' readers.
constexpr Signature kSignatures[] = {
    {"\x19\0\xfd\x12"sv, ".cbddlp"},
    {"\x86\0\xfd\x12"sv, ".ctb"},
    {"\x06\x01\xfd\x12"sv, ".ctb"},
    {"\x07\x01\xfd\x12"sv, ".ctb"},
    {"\x10\x08\x22\xff"sv, ".ctb"},
    {"\xae\x83\xda\x9f"sv, ".phz"},
    {"\xc8\x7a\x3c\xbd"sv, ".fdg"},
    {"V3.0\x07\0\0\0DLP\0"sv, ".goo"},
    {"ANYCUBIC"sv, ".pws"},
    {"\0\0\0\x09"
     "CXSW3DV2"sv,
     ".cxdlp"},
    {"\0\0\0\x07MKSDLP"sv, ".mdlp"},
    {"OSLATiCo"sv, ".osla"},
    {"Longer3D"sv, ".lgs"},
    {"DLP-II 1.1\n"sv, ".svgx"},
    {"GCDE"sv, ".bgcode"},
    {"BLENDER"sv, ".blend"},
    {"QC4DC4D6"sv, ".c4d"},
    {"//Maya ASCII"sv, ".ma"},
    {"ISO-10303-21"sv, ".step"},
    {"AutoCAD Binary DXF"sv, ".dxf"},
    {"V5_CFV"sv, ".catpart"},
    {"#UGC:"sv, ".prt"},
    {"**ABCDEFGHIJKLMNOPQRSTUVWXYZ"sv, ".x_t"},
    {"PS\0\0"sv, ".x_b"},
    {"ACIS BinaryFile"sv, ".sab"},
    {"DBRep_DrawableShape"sv, ".brep"},
    {"CASCADE Topology"sv, ".brep"},
    {"3D Geometry File Format"sv, ".3dm"},
    {"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0"sv, ".skp"},
    {"Kaydara FBX"sv, ".fbx"},
    {"; FBX "sv, ".fbx"},
    {"glTF"sv, ".glb"},
    {"*3DSMAX_ASCIIEXPORT"sv, ".ase"},
    {"xof 0"sv, ".x"},
    {"AC3D"sv, ".ac"},
    {"Caligari "sv, ".cob"},
    {"#VRML"sv, ".wrl"},
    {"#X3D"sv, ".x3d"},
    {"#usda"sv, ".usd"},
    {"PXR-USDC"sv, ".usd"},
    {"U3D\0"sv, ".u3d"},
    {"OCTM"sv, ".ctm"},
    {"DRACO"sv, ".drc"},
    {"# vtk DataFile"sv, ".vtk"},
    {"$MeshFormat"sv, ".msh"},
    {"Ogawa"sv, ".abc"},
    {"\xff\xd8\xff"sv, ".jpg"},
    {"\x89PNG\r\n"sv, ".png"},
    {"GIF8"sv, ".gif"},
    {"II*\0"sv, ".tif"},
    {"MM\0*"sv, ".tif"},
    {"%PDF-"sv, ".pdf"},
};

/// Roots of XML documents.
constexpr Signature kRoots[] = {
    {"amf", ".amf"},
    {"COLLADA", ".dae"},
    {"X3D", ".x3d"},
    {"VTKFile", ".vtk"},
};

const ForeignFormat* row_of(std::string_view ending) {
  for (const ForeignFormat& format : kFormats) {
    LineWords words(format.endings);
    for (auto word = words.next(); !word.empty(); word = words.next()) {
      if (same_word(word, ending)) return &format;
    }
  }
  return nullptr;
}

/// Takes the next line; an empty one counts.
std::string_view take_line(std::string_view& rest) {
  const auto line = rest.substr(0, std::min(rest.find_first_of("\r\n"), rest.size()));
  rest.remove_prefix(line.size());
  rest.remove_prefix(rest.starts_with("\r\n") ? 2 : std::min<std::size_t>(rest.size(), 1));
  return line;
}

/// The name of the first element of an XML document; empty: it is none, or the name is farther away.
std::string_view root_of(std::string_view text) {
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    text.remove_prefix(at + 1);
    if (text.starts_with("!--")) {
      text.remove_prefix(std::min(text.find("-->"), text.size()));
    } else if (!text.starts_with('?') && !text.starts_with('!')) {
      return text.substr(0, std::min(text.find_first_of(" \t\r\n/>"), text.size()));
    }
    at = 0;
  }
  return {};
}

/// A DXF begins with a section (group 0, SECTION), perhaps after comments (group 999).
bool is_dxf(std::string_view head) {
  for (;;) {
    const auto code = LineWords(take_line(head)).next();
    const auto value = LineWords(take_line(head)).next();
    if (code != "999") return code == "0" && value == "SECTION";
  }
}

/// A line of an IGES has 72 characters, S for its first section, and the line's number in that section.
bool is_iges(std::string_view head) {
  const auto line = take_line(head);
  return line.size() == 80 && (line[72] == 'S' || line[72] == 'C') &&
         LineWords(line.substr(73)).next().ends_with('1') &&
         line.find_first_not_of(" 01", 73) == std::string_view::npos;
}

/// The second line of an ACIS text names it; the first one has three or four whole numbers.
bool is_sat(std::string_view head) {
  const auto first = take_line(head);
  return first.find_first_not_of(" 0123456789") == std::string_view::npos &&
         take_line(head).find(" ACIS ") != std::string_view::npos;
}

/// A 3D Studio file and a BMP begin with two letters and the file's length.
bool has_length(std::string_view head, std::string_view letters, std::optional<std::uint64_t> size) {
  if (!head.starts_with(letters) || head.size() < 6) return false;
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    length |= std::uint64_t{static_cast<unsigned char>(head[2 + i])} << (8 * i);
  }
  return length == size;
}

/// "G28", "M140": a letter and a number.
bool is_gcode_command(std::string_view word) {
  return word.size() > 1 && (word[0] == 'G' || word[0] == 'M') &&
         word.find_first_not_of("0123456789.", 1) == std::string_view::npos;
}

/// The first two lines that are no comments are commands.
bool is_gcode(std::string_view head) {
  int commands = 0;
  while (!head.empty() && commands < 2) {
    const auto word = LineWords(take_line(head)).next();
    if (word.empty() || word[0] == ';') continue;
    if (!is_gcode_command(word)) return false;
    ++commands;
  }
  return commands == 2;
}

}  // namespace

const ForeignFormat* foreign_format(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return nullptr;
  const ForeignFormat* const format = row_of(name.substr(dot));
  const bool is_picture = format != nullptr && &format->kind == &kPicture;
  return is_picture ? nullptr : format;  // pictures beside scans are passed over
}

const ForeignFormat* foreign_content(std::string_view head, std::optional<std::uint64_t> size) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  for (const Signature& signature : kSignatures) {
    if (head.starts_with(signature.bytes)) return row_of(signature.ending);
  }
  if (is_dxf(head)) return row_of(".dxf");
  if (is_iges(head)) return row_of(".iges");
  if (is_sat(head)) return row_of(".sat");
  if (has_length(head, "MM", size)) return row_of(".3ds");
  if (has_length(head, "BM", size)) return row_of(".bmp");
  if (is_gcode(head)) return row_of(".gcode");
  constexpr std::size_t kTarMagic = 257;
  if (head.size() > kTarMagic && head.substr(kTarMagic).starts_with("ustar")) return row_of(".tar");
  if (head.starts_with("RIFF") && head.size() > 8 && head.substr(8).starts_with("WEBP")) return row_of(".webp");
  if (head.size() > 8 && head.substr(4).starts_with("ftyp")) {
    const auto brand = head.substr(8, 4);
    if (brand == "heic" || brand == "heix" || brand == "mif1" || brand == "avif") return row_of(".heic");
  }
  constexpr std::size_t kVersion = 80;  // bytes of a JT's first field
  if (head.starts_with("Version ") && head.substr(0, kVersion).find(" JT") != std::string_view::npos) {
    return row_of(".jt");
  }
  if (head.starts_with("AC10") && head.size() > 6 && head[6] == 0) return row_of(".dwg");
  if (head.starts_with("FORM") && head.size() > 8 &&
      (head.substr(8).starts_with("LWO") || head.substr(8).starts_with("LXOB"))) {
    return row_of(".lwo");
  }
  if (head.starts_with("FOR") && head.substr(0, 64).find("Maya") != std::string_view::npos) return row_of(".mb");
  if (head.starts_with('{') && head.find("\"asset\"") != std::string_view::npos) return row_of(".gltf");
  if (head.starts_with('<')) {
    const auto root = root_of(head);
    for (const Signature& known : kRoots) {
      if (root == known.bytes) return row_of(known.ending);
    }
  }
  return nullptr;
}

}  // namespace plumbline::inline slicer
