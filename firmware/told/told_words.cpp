#include "firmware/told/told_words.hpp"

#include <array>

#include "firmware/io/text/json_writer.hpp"

namespace plumbline {
namespace {

/// A namespace for each table: the codes of told_words.cpp, fault_words.cpp and words.cpp share names.
namespace told_table {
using enum ToldCode;
using enum PrinterCode;

struct Row {
  template <class Code>
  requires kExtends<Code, ToldCode>
  constexpr Row(Code what, std::string_view its_key, ToldWords its_words)
      : code(static_cast<ToldCode>(what)), key(its_key), words(its_words) {}
  ToldCode code;
  std::string_view key;  ///< on the state socket
  ToldWords words;
};

// Where an issue is, if it is in one place.
#define PLACE "[ bei x {x_mm}, y {y_mm}, z {from_mm} mm][, Schicht {layer}][, Schichten {first_layer}–{last_layer}]"

/// By code.
constexpr std::array kTold{
    // The slicer's.
    Row{kTooWide,
        "too_wide",
        {"Das Objekt ist {width_mm} mm breit, Platz ist für {limit_mm} mm: {excess_mm} mm zu viel",
         "Unter Einstellungen drehen oder kleiner drucken."}},
    Row{kTooDeep,
        "too_deep",
        {"Das Objekt ist {depth_mm} mm tief, Platz ist für {limit_mm} mm: {excess_mm} mm zu viel",
         "Unter Einstellungen drehen oder kleiner drucken."}},
    Row{kTooHigh,
        "too_high",
        {"Das Objekt ist {height_mm} mm hoch, Platz ist für {limit_mm} mm: {excess_mm} mm zu viel",
         "Unter Einstellungen kippen oder kleiner drucken."}},
    Row{kTooHighOnSupports,
        "too_high_on_supports",
        {"Das Objekt ist {height_mm} mm hoch, Stützen heben es um {lift_mm} mm: {excess_mm} mm zu viel",
         "Unter Einstellungen kippen, kleiner oder ohne Stützen drucken."}},
    Row{kTooManySupports,
        "too_many_supports",
        {"Das Objekt braucht mehr als {count} Stützen", "Unter Einstellungen drehen oder kippen."}},
    Row{kMemoryNeeded,
        "memory_needed",
        {"Der Auftrag braucht {needed_mib} MiB Speicher, {available_mib} MiB sind frei",
         "Kleiner oder mit dickeren Schichten drucken."}},
    Row{kTooSmall, "too_small", {"Das Objekt wäre nur {longest_mm} mm lang", "Unter Einstellungen die Höhe wählen."}},
    Row{kBelowFloor,
        "below_floor",
        {"Der ganze Scan liegt unter dem Boden bei Höhe {floor}",
         "floor = \"keep\" in job.toml auf dem Stick setzen."}},
    Row{kNoTriangles,
        "no_triangles",
        {"Das Modell hat kein brauchbares Dreieck", "Das Modell neu exportieren, mit seinen Flächen."}},
    Row{kSurfaceNotFound,
        "surface_not_found",
        {"In {points} {points?Punkt|Punkten} ist keine Oberfläche zu finden",
         "Die Normalen des Scans prüfen oder dichter scannen."}},
    Row{kMeshChanged,
        "mesh_changed",
        {"Die Datei hat sich beim Lesen geändert, oder der Stick versagt",
         "Noch einmal, oder mit einem anderen Stick."}},
    Row{kNotPoints,
        "not_points",
        {"Die Datei ist ein Modell ohne Punkte",
         "Als Modell drucken: as = \"points\" aus job.toml auf dem Stick nehmen."}},
    Row{kNoFaces,
        "no_faces",
        {"Die Datei hat Punkte, aber keine Flächen", "as = \"points\" in job.toml auf dem Stick setzen."}},
    Row{kLaz, "laz", {"{name} ist ein komprimierter Scan (LAZ)", "Als LAS speichern, mit CloudCompare oder laszip."}},
    Row{kSplatsCompressed,
        "splats_compressed",
        {"Das sind Splats in einem komprimierten PLY", "Als PLY ohne Kompression oder als SPZ exportieren."}},
    Row{kFileEmpty, "file_empty", {"Die Datei ist leer", "Die Datei neu kopieren oder exportieren."}},
    Row{kForeignPrint,
        "foreign_print",
        {"{name} ist für einen anderen Drucker geslict", "Aus dem Slicer als .sl1 exportieren."}},
    Row{kForeignFilament,
        "foreign_filament",
        {"{name} ist für einen Filamentdrucker geslict", "Das Modell selbst als STL exportieren."}},
    Row{kForeignProject,
        "foreign_project",
        {"{name} ist das Projekt eines anderen Programms", "Das Modell darin als STL exportieren."}},
    Row{kForeignCad, "foreign_cad", {"{name} ist ein CAD-Modell", "Im CAD-Programm als STL oder 3MF exportieren."}},
    Row{kForeignModel,
        "foreign_model",
        {"{name} ist ein Modell von einer Art, die plumbline nicht liest",
         "Als STL, OBJ, PLY, OFF oder 3MF exportieren."}},
    Row{kForeignScan,
        "foreign_scan",
        {"{name} ist ein Scan von einer Art, die plumbline nicht liest",
         "Die Punkte als E57, PLY oder LAS exportieren."}},
    Row{kForeignSplats,
        "foreign_splats",
        {"{name} sind Splats von einer Art, die plumbline nicht liest", "Als SPZ oder PLY exportieren."}},
    Row{kPacked, "packed", {"{name} ist gepackt", "Auspacken, und was darin ist auf den Stick kopieren."}},
    Row{kPicture, "picture", {"{name} ist ein Bild", "Einen Scan, ein Modell oder ein Archiv (.sl1) nehmen."}},
    Row{kWebPage, "web_page", {"{name} ist eine Webseite", "Die Datei selbst herunterladen."}},
    Row{kWideText, "wide_text", {"{name} ist Text in UTF-16 oder UTF-32", "Als UTF-8 oder ASCII speichern."}},

    // The printer's.
    Row{kIsland,
        "island",
        {"{count} {count?Insel von|Inseln bis} {area_mm2} mm²" PLACE, "Stützen setzen oder drehen."}},
    Row{kOverhang,
        "overhang",
        {"{count} {count?Überhang von|Überhänge bis} {area_mm2} mm²" PLACE, "Stützen setzen oder drehen."}},
    Row{kFreePiece,
        "free_piece",
        {"{count} {count?Stück, das|Stücke, die} nichts hält, {percent} % des Drucks, {count?|bis }{volume_ml} "
         "ml" PLACE,
         "Stützen setzen oder drehen."}},
    Row{kTear,
        "tear",
        {"{count} {count?Stück, das abreißt,|Stücke, die abreißen,} {count?|bis }{volume_ml} ml" PLACE,
         "Stützen setzen oder drehen."}},
    Row{kResinTrap,
        "resin_trap",
        {"{count} {count?Harzfalle von|Harzfallen bis} {volume_ml} ml" PLACE,
         "Im Modell ein Loch zum Ablaufen vorsehen."}},
    Row{kSuctionCup,
        "suction_cup",
        {"{count} {count?Saugnapf von|Saugnäpfe bis} {volume_ml} ml" PLACE,
         "Drehen, oder im Modell nahe der Platte ein Loch vorsehen."}},
    Row{kTouchingBound,
        "touching_bound",
        {"{count} {count?Teil|Teile} am Rand des LCD, {count?|bis }{area_mm2} mm²" PLACE,
         "Das Objekt kleiner drucken."}},
    Row{kEmptyLayer,
        "empty_layer",
        {"{count} {count?Lücke|Lücken} aus leeren Schichten" PLACE, "Was darüber ist, fällt: das Objekt drehen."}},
    Row{kPrintHeight,
        "print_height",
        {"{count} {count?Teil|Teile} über dem Weg der Z-Achse" PLACE, "Das Objekt niedriger drucken oder drehen."}},
    Row{kFirstLayerArea,
        "first_layer_area",
        {"Kleine erste Schicht von {area_mm2} mm²" PLACE, "Es könnte abfallen: drehen oder Stützen setzen."}},
    Row{kPeelArea,
        "peel_area",
        {"{count} große {count?Schicht von|Schichten bis} {area_mm2} mm²" PLACE,
         "Drehen, oder ein Profil wählen, das langsamer hebt."}},
    Row{kPeelJump,
        "peel_jump",
        {"{count} {count?Sprung|Sprünge} der Fläche um {count?|bis zu }{area_mm2} mm²" PLACE,
         "So drehen, dass die Fläche langsam wächst."}},

    Row{kUnitsIgnored,
        "units_ignored",
        {"Die Einheit {name} gilt nicht: die Datei nennt ihre eigene",
         "Wenn die Größe falsch ist: unter Einstellungen die Höhe wählen."}},
    Row{kUnitsGuessed,
        "units_guessed",
        {"Der Scan nennt keine Einheit. {name} ist geraten: {longest_mm} mm lang",
         "Wenn das falsch ist: unter Einstellungen die Höhe wählen."}},
    Row{kObjectSmall,
        "object_small",
        {"Das Objekt ist nur {longest_mm} mm lang", "Wenn das falsch ist: unter Einstellungen die Höhe wählen."}},
    Row{kObjectLarge,
        "object_large",
        {"Das Objekt ist {longest_mm} mm lang", "Wenn das falsch ist: unter Einstellungen die Höhe wählen."}},
    Row{kObjectThin,
        "object_thin",
        {"Der Scan ist {width_mm} × {depth_mm} × {height_mm} mm, in einer Richtung zu dünn zum Drucken",
         "Die Schichten ansehen."}},
    Row{kPointsAveraged,
        "points_averaged",
        {"Der Scan hat mehr Punkte, als in den Speicher passen: gemittelt über {cell_mm} mm, ein Pixel ist {pixel_mm} "
         "mm",
         "Feine Einzelheiten fehlen."}},
    Row{kTrianglesLeftOut,
        "triangles_left_out",
        {"{count} von {of} Dreiecken des Modells {count?fehlt|fehlen}: ihre Koordinaten sind unbrauchbar",
         "Die Vorschau ansehen."}},
    Row{kFacesTurned,
        "faces_turned",
        {"Einige Flächen des Modells sind umgedreht ({count} von {of} Strahlen)", "Die Vorschau ansehen."}},
    Row{kMeshOpen,
        "mesh_open",
        {"Das Modell ist nicht geschlossen ({count} von {of} Strahlen): Löcher, verdrehte oder doppelte Flächen",
         "Die Vorschau ansehen."}},
    Row{kSmallHolesClosed,
        "small_holes_closed",
        {"Das Modell hatte {count} kleine {count?Lücke|Lücken} (fehlende, verdrehte, doppelte Flächen), die "
         "geschlossen {count?wurde|wurden}",
         "Die Vorschau ansehen."}},
    Row{kRaysCrowded,
        "rays_crowded",
        {"{count} {count?Strahl schneidet|Strahlen schneiden} das Modell mehr als 254-mal, was darüber ist, fehlt",
         "Die Vorschau ansehen."}},
    Row{kFloorCut,
        "floor_cut",
        {"Ein Boden ist abgeschnitten, {width_mm} × {depth_mm} × {height_mm} mm",
         "Soll er als Sockel mit: floor = \"keep\" in job.toml auf dem Stick."}},
    Row{kPiecesLeftOut,
        "pieces_left_out",
        {"{count} {count?loses Stück fehlt|lose Stücke fehlen}: {points} {points?Punkt|Punkte}, {percent} % der "
         "Oberfläche",
         "Soll es mit: keep_all = true in job.toml auf dem Stick."}},
    Row{kNormalsAtRandom,
        "normals_at_random",
        {"Die Normalen des Scans zeigen wahllos nach innen und außen, {percent} % sind umgedreht",
         "Die Vorschau prüfen, oder neu scannen."}},
    Row{kInsideOut,
        "inside_out",
        {"Der Scan war von innen nach außen gekehrt, {percent} % der Normalen sind umgedreht", {}}},
    Row{kNormalsFlipped, "normals_flipped", {"{percent} % der Normalen zeigten ins Objekt und sind umgedreht", {}}},
    Row{kSolidsLeftOut,
        "solids_left_out",
        {"{count} {count?kleiner Körper fehlt, der|kleine Körper fehlen, die} weder Objekt noch Platte "
         "{count?berührt|berühren}",
         "Soll es mit: keep_all = true in job.toml auf dem Stick."}},
    Row{kMuchRemoved,
        "much_removed",
        {"Kleine Körper fehlen ({percent} % des Drucks): vielleicht dünne Wände",
         "Vorschau ansehen. Dichter scannen oder größer drucken."}},
    Row{kManyOutliers,
        "many_outliers",
        {"{percent} % der Punkte liegen auf keiner Fläche und fehlen", "Die Vorschau ansehen, oder neu scannen."}},
    Row{kCavitiesFilled,
        "cavities_filled",
        {"{count} {count?kleiner Hohlraum, den kein Scanner sieht, ist|kleine Hohlräume, die kein Scanner sieht, sind} "
         "gefüllt",
         "Soll es hohl bleiben: keep_all = true in job.toml auf dem Stick."}},
    Row{kSmallPartsStay,
        "small_parts_stay",
        {"Der Speicher reichte nicht, um lose Stücke, Hohlräume und Scanfehler zu suchen: sie werden gedruckt",
         "Die Vorschau ansehen."}},
    Row{kOnItsFace,
        "on_its_face",
        {"Der Scan zeigt nur eine Seite, und die liegt unten: das meiste lässt sich nicht schließen",
         "Unter Einstellungen um 180° kippen; dann wird es ein Relief."}},
    Row{kLiesWrong,
        "lies_wrong",
        {"Der Scan liegt wohl auf der Seite oder auf dem Kopf[ (x {turn_x_deg}°)][ (y {turn_y_deg}°)]",
         "Unter Einstellungen kippen oder die beste Lage suchen."}},
    Row{kNormalsEstimated,
        "normals_estimated",
        {"{points} {points?Punkt|Punkte} ohne brauchbare Normale, sie ist aus den Nachbarn geschätzt", {}}},

    Row{kMayShowMark,
        "may_show_mark",
        {"Der Druck war vor Schicht {layer} unterbrochen, dort kann eine Spur bleiben", {}}},
    Row{kMasksLate,
        "masks_late",
        {"{count} {count?Maske kam|Masken kamen} zu spät; die Belichtung hat gewartet und ist vollständig", {}}},
    Row{kDosesOff,
        "doses_off",
        {"{count} {count?Belichtung wich|Belichtungen wichen} um mehr als 1 % von der Dosis ab",
         "Die Lampe messen lassen."}},
    Row{kStepsLost,
        "steps_lost",
        {"Die Z-Achse war am Ende {off_mm} mm daneben, das Teil kann einen Absatz haben",
         "Nachsehen, was die Z-Achse blockiert."}},
    Row{kReportFull,
        "report_full",
        {"Im Bericht {count?fehlt|fehlen} {count} {count?Belichtung|Belichtungen}: er ist voll", {}}},

    Row{kFileNotOpened, "file_not_opened", {"Die Datei lässt sich nicht öffnen", {}}},
    Row{kFileNotRead,
        "file_not_read",
        {"Die Datei lässt sich nicht lesen: der Stick versagt", "Die Datei auf einen anderen Stick kopieren."}},
    Row{kFormatUnknown,
        "format_unknown",
        {"Die Datei ist von keiner Art, die plumbline liest",
         "Als STL, OBJ, PLY, OFF, 3MF, PCD, XYZ oder .sl1 exportieren."}},
    Row{kFileDamaged, "file_damaged", {"Die Datei ist beschädigt", "Die Datei neu kopieren oder exportieren."}},
    Row{kFileCut,
        "file_cut",
        {"Die Datei ist nicht vollständig, das Ende fehlt", "Die Datei neu kopieren oder exportieren."}},
    Row{kNothingToPrint, "nothing_to_print", {"In der Datei ist nichts, was sich drucken lässt", {}}},
    Row{kVariantUnknown,
        "variant_unknown",
        {"Diese Variante der Dateiart liest plumbline nicht", "Anders exportieren, zum Beispiel als STL oder PLY."}},
    Row{kMemoryShort, "memory_short", {"Der Auftrag braucht mehr Speicher, als der Drucker hat", {}}},
    Row{kTooLarge, "too_large", {"Das Objekt ist größer, als der Drucker drucken kann", {}}},
    Row{kSettingWrong, "setting_wrong", {"Eine Einstellung ist falsch", {}}},
    Row{kNoSurface, "no_surface", {"Der Scan hat keine Oberfläche, die sich drucken lässt", {}}},

    Row{kBadSectors,
        "bad_sectors",
        {"Der Stick hat fehlerhafte Stellen oder ein beschädigtes Dateisystem",
         "Die Datei auf einen anderen Stick kopieren."}},
    Row{kReadingBroke,
        "reading_broke",
        {"Das Lesen der Datei ist abgebrochen: sie ist wohl beschädigt", "Die Datei neu exportieren."}},
    Row{kArchivePixels,
        "archive_pixels",
        {"Das Archiv ist für ein LCD mit {columns} × {rows} Pixeln, dieses hat {panel_columns} × {panel_rows}",
         "Für diesen Drucker neu slicen."}},
    Row{kArchivePanel,
        "archive_panel",
        {"Das Archiv ist für ein LCD von {width_mm} × {depth_mm} mm, dieses hat {panel_width_mm} × {panel_depth_mm} mm",
         "Für diesen Drucker neu slicen."}},
    Row{kArchiveHigh,
        "archive_high",
        {"Das Archiv ist mit {layers} {layers?Schicht|Schichten} {height_mm} mm hoch, die Z-Achse fährt {limit_mm} mm",
         "Niedriger slicen."}},
    Row{kExposureLong,
        "exposure_long",
        {"{name} belichtet {exposure_s} s, die Lampe darf {limit_s} s leuchten",
         "Kürzer belichten oder ein anderes Profil wählen."}},
    Row{kLightLong,
        "light_long",
        {"{name} belichtet {exposure_s} s in einer Minute, die Lampe darf {limit_s} s leuchten",
         "Kürzer belichten oder ein anderes Profil wählen."}},
    Row{kStageSlow,
        "stage_slow",
        {"{name} fährt {speed_mm_min} mm/min, die Z-Achse höchstens {limit_mm_min} mm/min",
         "Ein anderes Profil wählen."}},
    Row{kLastLiftHigh,
        "last_lift_high",
        {"Die Platte hebt am Ende bis {height_mm} mm, die Z-Achse fährt {limit_mm} mm: {excess_mm} mm zu viel",
         "Das Objekt um so viel niedriger drucken."}},
    Row{kProfileUnknown,
        "profile_unknown",
        {"Ein Profil {name} gibt es auf diesem Drucker nicht", "Unter Einstellungen ein anderes wählen."}},
    Row{kStickEmpty,
        "stick_empty",
        {"Auf dem Stick ist kein Scan, kein Modell und kein Archiv",
         "Eine Datei STL, OBJ, PLY, OFF, 3MF, PCD, XYZ oder .sl1 in den obersten Ordner kopieren."}},
    Row{kStickTwoJobs,
        "stick_two_jobs",
        {"Auf dem Stick sind zwei Aufträge, {name} ist einer", "Einen davon löschen."}},
    Row{kStickOtherJob,
        "stick_other_job",
        {"{name} sieht nach dem Auftrag des Sticks aus", "Die Datei job.toml nennen oder löschen."}},
    Row{kStickInnerJob,
        "stick_inner_job",
        {"{name} liegt in einem Ordner", "Die Datei in den obersten Ordner legen, mit dem Weg zum Scan darin."}},
    Row{kTooManyFiles,
        "too_many_files",
        {"Ein Scan darf höchstens {count} Dateien haben",
         "Einige zusammenfügen, oder die nötigen in job.toml nennen."}},
    Row{kArchiveSettings,
        "archive_settings",
        {"{name} ist schon geslict: von den Einstellungen gilt nur das Profil",
         "Die anderen weglassen, oder den Scan selbst auf den Stick kopieren."}},
    Row{kSettingUnknown,
        "setting_unknown",
        {"Die Einstellung {name} gibt es nicht", "Die Zeile in job.toml auf dem Stick löschen."}},
    Row{kSettingValue, "setting_value", {"Die Einstellung {name} hat einen falschen Wert", "Einen anderen wählen."}},

    Row{kMeasurePart,
        "measure_part",
        {"Das Teil messen: es muss {height_mm} mm hoch sein ({layers} {layers?Schicht|Schichten}). ▶ wenn ja, ✖ wenn "
         "es höher ist",
         {}}},
    Row{kLookAtPlate,
        "look_at_plate",
        {"Noch ist keine Schicht hart. Die Platte ansehen: ▶ wenn sie leer ist, ✖ wenn ein Teil daran hängt", {}}},

    Row{kStickMayGo, "stick_may_go", {"Der Stick kann abgezogen werden", {}}},
    Row{kReportsOnStick,
        "reports_on_stick",
        {"{count} {count?Datei|Dateien} der letzten Drucke {count?ist|sind} jetzt auf dem Stick, in plumbline-reports",
         {}}},
    Row{kReportsNotOnStick,
        "reports_not_on_stick",
        {"Die Berichte ließen sich nicht auf den Stick schreiben",
         "Platz auf dem Stick schaffen oder einen anderen nehmen."}},

    Row{kCheckMemory, "check_memory", {"{needed_mib} von {available_mib} MiB", {}}},
    Row{kCheckObject,
        "check_object",
        {"{layers} {layers?Schicht|Schichten}, steht auf der Platte; das letzte Heben endet bei {height_mm} mm, die "
         "Z-Achse fährt "
         "{limit_mm} mm",
         {}}},
    Row{kCheckObjectHangs,
        "check_object_hangs",
        {"{layers} {layers?Schicht|Schichten}, aber die erste ist leer: nichts hält das Objekt", {}}},
    Row{kCheckMasksClean, "check_masks_clean", {"nichts gefunden", {}}},
    Row{kCheckMasksIssues, "check_masks_issues", {"etwas gefunden: siehe Hinweise", {}}},
    Row{kCheckMasksBefore, "check_masks_before", {"geprüft, als der Druck begann", {}}},
    Row{kCheckLight, "check_light", {"eine Schicht von {height_mm} mm härtet {cure_mm} mm tief", {}}},
    Row{kCheckLampDark, "check_lamp_dark", {"dunkel", {}}},
    Row{kCheckLampLit, "check_lamp_lit", {"sie leuchtet, obwohl sie aus ist", {}}},
    Row{kCheckPanel, "check_panel", {"{columns} × {rows} Pixel, schwarz", {}}},
    Row{kCheckPanelOther,
        "check_panel_other",
        {"das LCD hat {panel_columns} × {panel_rows} Pixel, die Masken {columns} × {rows}", {}}},
    Row{kCheckCoverClosed, "check_cover_closed", {"geschlossen", {}}},
    Row{kCheckCoverOpen, "check_cover_open", {"offen", {}}},
    Row{kCheckCoverNone, "check_cover_none", {"dieser Drucker hat keinen Schalter an der Haube", {}}},
    Row{kCheckTemperatures,
        "check_temperatures",
        {"Lampe {lamp_c} °C, höchstens {lamp_limit_c}; Harz {resin_c} °C, erlaubt {resin_least_c} bis {resin_most_c}",
         {}}},
    Row{kCheckResin, "check_resin", {"{needed_ml} ml nötig, ein voller Tank hat {tank_ml} ml", {}}},
    Row{kCheckResinShort,
        "check_resin_short",
        {"{needed_ml} ml nötig, ein voller Tank hat {tank_ml} ml; der Druck pausiert zum Nachfüllen", {}}},
    Row{kCheckJournal, "check_journal", {"wird geführt", {}}},
    Row{kCheckJournalNone, "check_journal_none", {"keins: ein Stromausfall beendet den Druck für immer", {}}},
    Row{kCheckJournalDoubt,
        "check_journal_doubt",
        {"es endet bei {height_mm} mm, die Platte stand woanders: das Teil messen", {}}},
    Row{kCheckStage, "check_stage", {"Endschalter gefunden bei {height_mm} mm", {}}},

    Row{kUploadsOff,
        "uploads_off",
        {"Dieser Drucker nimmt nichts über das Netz an", "Den Scan auf einen Stick kopieren."}},
    Row{kUploadName,
        "upload_name",
        {"Der Drucker nimmt {name} mit diesem Namen nicht an",
         "Nur Buchstaben, Ziffern, Leerzeichen und ._-()+ verwenden."}},
    Row{kUploadKind,
        "upload_kind",
        {"{name} ist dem Namen nach kein Scan, kein Modell und kein Archiv",
         "Eine Datei STL, OBJ, PLY, OFF, 3MF, PCD, XYZ oder .sl1 hochladen."}},
    Row{kUploadEmpty, "upload_empty", {"Die Datei ist leer", "Den Scan neu exportieren."}},
    Row{kUploadLarge,
        "upload_large",
        {"Die Datei hat {needed_mib} MiB, der Drucker nimmt höchstens {available_mib} MiB", "Einen Stick verwenden."}},
    Row{kUploadNoRoom,
        "upload_no_room",
        {"Der Scan braucht {needed_mib} MiB, auf dem Drucker sind {available_mib} MiB frei",
         "Platz schaffen oder einen Stick verwenden."}},
    Row{kUploadNotNow,
        "upload_not_now",
        {"Der Drucker nimmt einen Scan nur an, wenn er nichts anderes tut", "Nach dem Druck hochladen."}},
    Row{kUploadOther, "upload_other", {"Ein anderer Scan wird gerade hochgeladen", "Noch einmal, wenn er da ist."}},
    Row{kUploadJobBegan,
        "upload_job_began",
        {"Der Drucker hat einen anderen Auftrag begonnen", "Danach noch einmal hochladen."}},
    Row{kUploadBroke,
        "upload_broke",
        {"Nach {received_mb} von {total_mb} MB brach das Hochladen ab", "Noch einmal hochladen."}},
    Row{kUploadSlow,
        "upload_slow",
        {"Das Hochladen war zu langsam: {received_mb} von {total_mb} MB kamen an",
         "Das Netz prüfen, dann noch einmal hochladen."}},
    Row{kUploadNotStored,
        "upload_not_stored",
        {"Der Scan lässt sich auf dem Drucker nicht speichern", "Platz schaffen oder einen Stick verwenden."}},
    Row{kUploadReplaced,
        "upload_replaced",
        {"Inzwischen ist ein anderer Scan hochgeladen", "Diesen noch einmal hochladen, oder den anderen drucken."}},
    Row{kNotInStore, "not_in_store", {"{name} ist nicht mehr auf dem Drucker", {}}},
    Row{kNotRemoved, "not_removed", {"Der Scan ließ sich nicht sicher löschen", "Den Speicher des Druckers prüfen."}},

    Row{kCommandNotNow, "command_not_now", {"Das geht jetzt nicht: der Drucker tut inzwischen etwas anderes", {}}},
    Row{kNoSuchScan, "no_such_scan", {"Scan {count} gibt es auf dem Stick nicht", {}}},
    Row{kCodeWrong, "code_wrong", {"Das ist nicht der Code", "Ihn am Bildschirm des Druckers ablesen."}},
    Row{kCodeOld, "code_old", {"Der Code gilt nicht mehr", "Einen neuen anfordern."}},
    Row{kCodesTooMany, "codes_too_many", {"Zu viele falsche Codes", "In einer Minute noch einmal."}},
};
#undef PLACE

}  // namespace told_table

using told_table::kTold;

constexpr bool is_complete() {
  for (std::size_t i = 0; i < kTold.size(); ++i) {
    if (static_cast<std::size_t>(kTold[i].code) != i + 1) return false;
  }
  return kTold.size() + 1 == kAllCodes;
}
static_assert(is_complete(),
              "a code has no key and German text, or the table is not in the order of ToldCode and PrinterCode");

}  // namespace

std::string_view to_string(ToldCode code) {
  return code == ToldCode::kNone ? "none" : kTold[static_cast<std::size_t>(code) - 1].key;
}

std::optional<ToldWords> told_words(ToldCode code, Language language) {
  if (language == Language::kEnglish || code == ToldCode::kNone) return std::nullopt;
  return kTold[static_cast<std::size_t>(code) - 1].words;
}

void write_told_words(JsonWriter& json, Language language) {
  json.key("told");
  json.begin_object(kOneLine);
  for (std::size_t i = 1; i < kAllCodes; ++i) {
    const auto code = static_cast<ToldCode>(i);
    const auto words = told_words(code, language);
    if (!words) continue;
    json.key(to_string(code));
    json.begin_array(kOneLine);
    json.value(words->sentence);
    json.value(words->remedy);
    json.end_array();
  }
  json.end_object();
  json.key("digits");
  json.begin_object(kOneLine);
  for (std::size_t i = 0; i < kAllFacts; ++i) {
    const FactFormat& format = format_of(static_cast<Fact>(i));
    if (format.decimals != 0) json.member(format.name, static_cast<double>(format.decimals));
  }
  json.end_object();
}

}  // namespace plumbline
