#include "firmware/screen/fault_words.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace plumbline {
namespace {

struct GermanFault {
  FaultCode code;
  FaultWords words;
};

using enum FaultCode;

/// kFaults of fault.cpp in German, by code.
constexpr std::array kGerman{
    GermanFault{kScanUnreadable, {"Scan ist nicht lesbar", "Name und Stick prüfen oder den Scan neu kopieren."}},
    GermanFault{kNotAScan,
                {"Kein Scan", "Den Scan neu als PLY, PCD, OBJ oder XYZ exportieren, ein Modell als STL oder 3MF."}},
    GermanFault{kNothingToPrint,
                {"Nichts zu drucken", "Den Scan im Programm des Scanners ansehen und mit seinen Punkten exportieren."}},
    GermanFault{kOutOfMemory,
                {"Passt nicht in den Speicher", "Das Objekt kleiner oder mit dickeren Schichten drucken."}},
    GermanFault{kDoesNotFit, {"Passt nicht in den Drucker", "Das Objekt verkleinern oder drehen."}},
    GermanFault{kBadSetting, {"Falsche Einstellung", "Die Zeile berichtigen, die die Meldung nennt."}},
    GermanFault{kStickGone, {"Stick abgezogen", "Den Stick wieder einstecken; der Auftrag beginnt von vorn."}},
    GermanFault{kNoStick, {"Kein Stick", "Einen Stick einstecken."}},
    GermanFault{kStickUnreadable,
                {"Stick ist nicht lesbar", "Den Stick als FAT32 oder exFAT formatieren und den Scan neu kopieren."}},
    GermanFault{
        kCannotWrite,
        {"Journal ist nicht schreibbar",
         "Platz schaffen oder den Speicher ersetzen. Ohne Journal beendet ein Stromausfall den Druck für immer."}},
    GermanFault{kIssueFound,
                {"Mangel in den Schichten", "Das Objekt drehen, Stützen setzen oder [checks] im Profil ändern."}},
    GermanFault{kJournalDamaged, {"Journal beschädigt", "Das Teil abnehmen, dann den Druck neu starten."}},
    GermanFault{kJournalOfAnother,
                {"Journal eines anderen Druckers",
                 "Mit Board-Datei und Version jenes Drucks fortsetzen, oder das Teil abnehmen und neu starten."}},
    GermanFault{kFlipTimeout, {"LCD nahm die Maske nicht an", "Das Kabel des LCD prüfen, dann fortsetzen."}},
    GermanFault{kPanelFailed, {"LCD antwortet nicht", "Das Kabel des LCD prüfen, dann fortsetzen."}},
    GermanFault{kPanelSize, {"Falsches LCD", "Die Board-Datei dieses Druckers verwenden."}},
    GermanFault{kLampStuckOn,
                {"Lampe geht nicht aus", "Sofort den Stecker ziehen, dann den Lampentreiber ersetzen lassen."}},
    GermanFault{kLampDead, {"Lampe ist dunkel", "Lampe, Kabel und Sicherung prüfen, dann fortsetzen."}},
    GermanFault{kLampKeeper,
                {"Lampe unbewacht", "Fortsetzen. Wenn es wieder vorkommt, den Drucker aus- und einschalten."}},
    GermanFault{kExposureTooLong, {"Belichtung zu lang", "exposure_time oder initial_exposure_time verkürzen."}},
    GermanFault{kDoseOff, {"Falsche Dosis", "Die Lampe messen lassen, power_mw_cm2 berichtigen, dann fortsetzen."}},
    GermanFault{kTooLittleLight,
                {"Zu wenig Licht", "exposure_time verlängern oder das Profil dieses Harzes verwenden."}},
    GermanFault{kEndStopNotFound, {"Endschalter nicht gefunden", "Endschalter und Kabel prüfen, dann fortsetzen."}},
    GermanFault{kEndStopStuck, {"Endschalter klemmt", "Den Endschalter lösen, dann fortsetzen."}},
    GermanFault{kStageStalled, {"Z-Achse blockiert", "Nachsehen, was die Z-Achse blockiert, dann fortsetzen."}},
    GermanFault{kOutsideTravel,
                {"Außerhalb des Wegs", "Das Objekt niedriger machen oder die Board-Datei berichtigen."}},
    GermanFault{kStepsLost,
                {"Schritte verloren", "Nachsehen, was die Z-Achse blockiert, und ob das Teil einen Absatz hat."}},
    GermanFault{kCoverOpen, {"Haube offen", "Die Haube schließen, dann neu starten."}},
    GermanFault{kSensorDead, {"Fühler antwortet nicht", "Den Stecker des Fühlers prüfen, dann fortsetzen."}},
    GermanFault{kLampTooHot, {"Lampe zu heiß", "Warten, bis die Lampe kühl ist, und prüfen, ob ihr Lüfter dreht."}},
    GermanFault{kResinTooCold, {"Harz zu kalt", "Raum oder Harz erwärmen, dann neu starten."}},
    GermanFault{kResinTooWarm, {"Harz zu warm", "Das Harz abkühlen lassen, dann neu starten."}},
    GermanFault{kFanStalled, {"Lüfter steht", "Den Lüfter reinigen oder ersetzen, dann fortsetzen."}},
    GermanFault{kPowerLost, {"Stromausfall", "Den Drucker einschalten, dann fortsetzen."}},
    GermanFault{kDeviceTimeout, {"Gerät antwortet nicht", "Den Drucker aus- und einschalten, dann fortsetzen."}},
    GermanFault{kFirmware,
                {"Fehler in der Firmware", "Fortsetzen und die Meldung an die Entwickler von plumbline schicken."}},
};

}  // namespace

FaultWords fault_words(FaultCode code, Language language) {
  const FaultInfo& fault = info(code);
  if (language == Language::kEnglish) return {fault.title, fault.next};
  const auto* const found =
      std::find_if(kGerman.begin(), kGerman.end(), [code](const GermanFault& row) { return row.code == code; });
  assert(found != kGerman.end());
  return found->words;
}

}  // namespace plumbline
