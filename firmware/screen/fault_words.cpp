#include "firmware/screen/fault_words.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace plumbline {
namespace {

/// A namespace for each table: see told_words.cpp.
namespace fault_table {
using enum FaultCode;

struct GermanFault {
  FaultCode code;
  FaultWords words;
};

/// kFaults of fault.cpp in German, by code.
constexpr std::array kFaultTexts{
    GermanFault{kScanUnreadable,
                {"Scan ist nicht lesbar", "Die Datei lässt sich nicht öffnen, oder ihr Stick versagt.",
                 "Name und Stick prüfen oder den Scan neu kopieren."}},
    GermanFault{kNotAScan,
                {"Kein Scan", "Die Datei ist beschädigt oder von einer Art, die plumbline nicht liest.",
                 "Den Scan neu als PLY, PCD, OBJ oder XYZ exportieren, ein Modell als STL oder 3MF."}},
    GermanFault{
        kNothingToPrint,
        {"Nichts zu drucken", "Der Scan hat keine Punkte, keine Oberfläche oder nichts, was auf der Platte steht.",
         "Den Scan im Programm des Scanners ansehen und mit seinen Punkten exportieren."}},
    GermanFault{kOutOfMemory,
                {"Passt nicht in den Speicher", "Der Auftrag braucht mehr Speicher, als der Drucker hat.",
                 "Das Objekt kleiner oder mit dickeren Schichten drucken."}},
    GermanFault{kDoesNotFit,
                {"Passt nicht in den Drucker", "Das Objekt ist größer als die Platte oder der Weg der Z-Achse.",
                 "Das Objekt verkleinern oder drehen."}},
    GermanFault{kBadSetting,
                {"Falsche Einstellung", "In Board-Datei, Profil oder job.toml ist etwas falsch.",
                 "Die Zeile berichtigen, die die Meldung nennt."}},
    GermanFault{kStickGone,
                {"Stick abgezogen", "Der Stick wurde abgezogen, während der Scan gelesen wurde.",
                 "Den Stick wieder einstecken; der Auftrag beginnt von vorn."}},
    GermanFault{kNoStick, {"Kein Stick", "Im Drucker steckt kein Stick.", "Einen Stick einstecken."}},
    GermanFault{kStickUnreadable,
                {"Stick ist nicht lesbar", "Der Stick hat kein Dateisystem, das sich lesen lässt.",
                 "Den Stick als FAT32 oder exFAT formatieren und den Scan neu kopieren."}},
    GermanFault{
        kCannotWrite,
        {"Journal ist nicht schreibbar", "Der Speicher des Druckers ist voll oder versagt.",
         "Platz schaffen oder den Speicher ersetzen. Ohne Journal beendet ein Stromausfall den Druck für immer."}},
    GermanFault{kIssueFound,
                {"Mangel in den Schichten", "Die Schichten haben etwas, das nach dem Profil nicht gedruckt wird.",
                 "Das Objekt drehen, Stützen setzen oder [checks] im Profil ändern."}},
    GermanFault{kJournalDamaged,
                {"Journal beschädigt",
                 "Was vom unterbrochenen Druck gespeichert war, ist beschädigt. Er lässt sich nicht fortsetzen.",
                 "Das Teil abnehmen, dann den Druck neu starten."}},
    GermanFault{kJournalOfAnother,
                {"Journal eines anderen Druckers",
                 "Der unterbrochene Druck begann mit einer anderen Board-Datei oder Version von plumbline.",
                 "Mit Board-Datei und Version jenes Drucks fortsetzen, oder das Teil abnehmen und neu starten."}},
    GermanFault{kFlipTimeout,
                {"LCD nahm die Maske nicht an", "Das LCD brauchte zu lange, um eine Maske zu zeigen.",
                 "Das Kabel des LCD prüfen, dann fortsetzen."}},
    GermanFault{
        kPanelFailed,
        {"LCD antwortet nicht", "Keine Maske lässt sich zeigen.", "Das Kabel des LCD prüfen, dann fortsetzen."}},
    GermanFault{kPanelSize,
                {"Falsches LCD", "Das LCD hat eine andere Zahl von Pixeln, als die Board-Datei sagt.",
                 "Die Board-Datei dieses Druckers verwenden."}},
    GermanFault{kLampStuckOn,
                {"Lampe geht nicht aus", "Es ist Licht da, obwohl die Lampe ausgeschaltet ist.",
                 "Sofort den Stecker ziehen, dann den Lampentreiber ersetzen lassen."}},
    GermanFault{kLampDead,
                {"Lampe ist dunkel", "Es ist kein Licht da, obwohl die Lampe eingeschaltet ist.",
                 "Lampe, Kabel und Sicherung prüfen, dann fortsetzen."}},
    GermanFault{kLampKeeper,
                {"Lampe unbewacht", "Der Wächter, der die Lampe rechtzeitig ausschaltet, versagte. Die Lampe ist aus.",
                 "Fortsetzen. Wenn es wieder vorkommt, den Drucker aus- und einschalten."}},
    GermanFault{kExposureTooLong,
                {"Belichtung zu lang", "Das Profil belichtet länger, als die Lampe leuchten darf.",
                 "exposure_time oder initial_exposure_time verkürzen."}},
    GermanFault{kDoseOff,
                {"Falsche Dosis", "Die Lampe gab über 5 % mehr oder weniger Licht als verlangt.",
                 "Die Lampe messen lassen, power_mw_cm2 berichtigen, dann fortsetzen."}},
    GermanFault{kTooLittleLight,
                {"Zu wenig Licht", "So belichtet härtet das Harz nicht durch eine ganze Schicht.",
                 "exposure_time verlängern oder das Profil dieses Harzes verwenden."}},
    GermanFault{kEndStopNotFound,
                {"Endschalter nicht gefunden", "Die Z-Achse fuhr den ganzen Weg, ohne den Endschalter zu treffen.",
                 "Endschalter und Kabel prüfen, dann fortsetzen."}},
    GermanFault{kEndStopStuck,
                {"Endschalter klemmt", "Der Endschalter ist gedrückt, wo er es nicht sein kann.",
                 "Den Endschalter lösen, dann fortsetzen."}},
    GermanFault{
        kStageStalled,
        {"Z-Achse blockiert", "Der Motor kam nicht mit.", "Nachsehen, was die Z-Achse blockiert, dann fortsetzen."}},
    GermanFault{kOutsideTravel,
                {"Außerhalb des Wegs", "Die Z-Achse soll auf eine Höhe, die sie nicht erreicht.",
                 "Das Objekt niedriger machen oder die Board-Datei berichtigen."}},
    GermanFault{kStepsLost,
                {"Schritte verloren", "Die Z-Achse war nicht dort, wo sie nach ihren Schritten sein soll.",
                 "Nachsehen, was die Z-Achse blockiert, und ob das Teil einen Absatz hat."}},
    GermanFault{kCoverOpen,
                {"Haube offen", "Die Haube war offen, als der Druck beginnen sollte.",
                 "Die Haube schließen, dann neu starten."}},
    GermanFault{kSensorDead,
                {"Fühler antwortet nicht", "Ein Temperaturfühler antwortet nicht oder meldet Unmögliches.",
                 "Den Stecker des Fühlers prüfen, dann fortsetzen."}},
    GermanFault{kLampTooHot,
                {"Lampe zu heiß", "Die Lampe ist über ihrer Grenze.",
                 "Prüfen, ob ihr Lüfter dreht. Der Druck geht von selbst weiter, wenn sie kühl ist."}},
    GermanFault{kResinTooCold,
                {"Harz zu kalt", "Kaltes Harz ist zäh und härtet zu wenig.",
                 "Raum oder Harz erwärmen. Der Druck geht von selbst weiter."}},
    GermanFault{
        kResinTooWarm,
        {"Harz zu warm", "Warmes Harz härtet zu tief.", "Das Harz abkühlen lassen. Der Druck geht von selbst weiter."}},
    GermanFault{kFanStalled,
                {"Lüfter steht", "Der Lüfter der Lampe ist an und dreht sich nicht.",
                 "Den Lüfter reinigen oder ersetzen. Der Druck geht von selbst weiter, wenn er dreht."}},
    GermanFault{kBoardTooHot,
                {"Elektronik zu heiß", "Der Prozessor des Druckers ist über seiner Grenze.",
                 "Ihm Luft verschaffen. Der Druck geht von selbst weiter, wenn er kühl ist."}},
    GermanFault{kChamberFanStalled,
                {"Kammerlüfter steht", "Der Lüfter, der die Dämpfe absaugt, ist an und dreht sich nicht.",
                 "Den Lüfter reinigen oder ersetzen. Der Druck geht von selbst weiter, wenn er dreht."}},
    GermanFault{kPowerLost,
                {"Stromausfall", "Die Stromversorgung fiel aus.", "Den Drucker einschalten, dann fortsetzen."}},
    GermanFault{kDeviceTimeout,
                {"Gerät antwortet nicht", "Ein Gerät wurde nicht fertig mit dem, was es begonnen hat.",
                 "Den Drucker aus- und einschalten, dann fortsetzen."}},
    GermanFault{kFirmware,
                {"Fehler in der Firmware", "Die Firmware verlangte von einem Gerät, was nicht erlaubt ist.",
                 "Fortsetzen und die Meldung an die Entwickler von plumbline schicken."}},
};

}  // namespace fault_table

using fault_table::GermanFault;
using fault_table::kFaultTexts;

}  // namespace

FaultWords fault_words(FaultCode code, Language language) {
  const FaultInfo& fault = info(code);
  if (language == Language::kEnglish) return {fault.title, fault.meaning, fault.next};
  const auto* const found =
      std::find_if(kFaultTexts.begin(), kFaultTexts.end(), [code](const GermanFault& row) { return row.code == code; });
  assert(found != kFaultTexts.end());
  return found->words;
}

}  // namespace plumbline
