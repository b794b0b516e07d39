#include "firmware/screen/words.hpp"

#include <array>

namespace plumbline {
namespace {

/// A namespace for each table: see told_words.cpp.
namespace words_table {

struct Row {
  Words which;
  std::array<std::string_view, kLanguageCount> text;  ///< by Language
};

using enum Words;

constexpr std::array kTexts{
    Row{kReady, {"Ready", "Bereit"}},
    Row{kScans, {"Scans on the stick", "Scans auf dem Stick"}},
    Row{kUploadedScan, {"Uploaded scan", "Hochgeladener Scan"}},
    Row{kSettings, {"Settings", "Einstellungen"}},
    Row{kReading, {"Reading the scan", "Scan wird gelesen"}},
    Row{kPreview, {"Print this?", "Das drucken?"}},
    Row{kChecks, {"Checks", "Prüfungen"}},
    Row{kHoming, {"Finding the end stop", "Endschalter suchen"}},
    Row{kPrinting, {"Printing", "Druckt"}},
    Row{kCancelQuestion, {"Cancel the print?", "Druck abbrechen?"}},
    Row{kDeleteQuestion, {"Delete the scan?", "Den Scan löschen?"}},
    Row{kPausing, {"Pausing", "Pausiert gleich"}},
    Row{kPaused, {"Paused", "Pause"}},
    Row{kCoverOpen, {"The cover is open", "Haube ist offen"}},
    Row{kCoolingDown, {"Waiting", "Wartet"}},
    Row{kResinLow, {"Resin is low", "Wenig Harz im Tank"}},
    Row{kRaising, {"Raising the part", "Teil wird angehoben"}},
    Row{kFinished, {"Finished", "Fertig"}},
    Row{kCancelled, {"Cancelled", "Abgebrochen"}},
    Row{kPlateInUse, {"Plate in use", "Platte belegt"}},
    Row{kInterrupted, {"Print interrupted", "Druck unterbrochen"}},
    Row{kEnding, {"Shutting down", "Wird beendet"}},
    Row{kFault, {"Fault", "Fehler"}},
    Row{kPrints, {"Last prints", "Letzte Drucke"}},
    Row{kLightCard, {"Lights and buzzer", "Lichter und Summer"}},

    Row{kPlugIn, {"Plug in a USB stick with a scan", "USB-Stick mit einem Scan einstecken"}},
    Row{kScanKinds,
        {"or a mesh: PLY, XYZ, OBJ, STL, 3MF and more", "oder einem Modell: PLY, XYZ, OBJ, STL, 3MF und mehr"}},
    Row{kResinLeft, {"%s ml of resin in the tank", "%s ml Harz im Tank"}},
    Row{kStickIsIn, {"The stick is in", "Der Stick steckt"}},
    Row{kShowAgain,
        {"▶ shows its scans. Or plug in another stick.", "▶ zeigt, was darauf ist. Oder einen anderen einstecken."}},
    Row{kShowUpload, {"▶ shows the scan that was uploaded.", "▶ zeigt den hochgeladenen Scan."}},
    Row{kJobFileAsks, {"job.toml asks for this scan", "job.toml verlangt diesen Scan"}},
    Row{kScansAsOne, {"%u scans as one", "%u Scans als einer"}},
    Row{kEmptyStick, {"Reading the stick", "Stick wird angesehen"}},
    Row{kPleaseWait, {"Please wait", "Bitte warten"}},
    Row{kStep, {"Step %u of %u", "Schritt %u von %u"}},
    Row{kNoPicture, {"no picture", "kein Bild"}},
    Row{kLayers, {"%u layers", "%u Schichten"}},
    Row{kOneLayer, {"1 layer", "1 Schicht"}},
    Row{kNoFindings, {"✓ No issues found", "✓ Keine Hinweise"}},
    Row{kPartIsRaised,
        {"The part is being raised. Keep the cover closed.", "Das Teil wird angehoben. Haube geschlossen lassen."}},
    Row{kAskedToCancel,
        {"The part stays as it is now and can't be completed.",
         "Das Teil bleibt, wie es jetzt ist. Es kann nicht fertig werden."}},
    Row{kFolderUp, {"Up one folder", "Eine Ebene höher"}},
    Row{kFolderHolds, {"%u inside", "%u darin"}},
    Row{kDeleteScan, {"Delete this scan", "Diesen Scan löschen"}},
    Row{kAskedToDelete,
        {"It will be deleted from the printer. This can't be undone.",
         "Er wird vom Drucker gelöscht und lässt sich nicht zurückholen."}},
    Row{kAfterLayer, {"The part will be raised after this layer.", "Nach dieser Schicht wird das Teil angehoben."}},
    Row{kPressToGoOn, {"Press ▶ to resume the print.", "▶ setzt den Druck fort."}},
    Row{kCoverFirst,
        {"Close the cover: the plate does not move while it is open.",
         "Haube schließen: solange sie offen ist, bewegt sich die Platte nicht."}},
    Row{kCloseCover, {"Close the cover, then press ▶.", "Haube schließen. Dann setzt ▶ den Druck fort."}},
    Row{kLampCools, {"The print resumes by itself.", "Der Druck geht von selbst weiter."}},
    Row{kRefill, {"Fill the tank, close the cover, then press ▶.", "Tank füllen, Haube schließen, dann ▶ drücken."}},
    Row{kTakePartOff, {"Take the part off", "Teil abnehmen"}},
    Row{kIsPlateEmpty,
        {"Is the plate empty and back in? Then press ▶.",
         "Ist die Platte leer und wieder eingesetzt? Dann ▶ drücken."}},
    Row{kCanGoOn, {"The print can be resumed", "Der Druck kann weitergehen"}},
    Row{kGoOnOrGiveUp,
        {"▶ resumes it where it stopped. ✖ abandons it.", "▶ macht weiter, wo er aufgehört hat. ✖ gibt ihn auf."}},
    Row{kLayerOf, {"Layer %u of %u", "Schicht %u von %u"}},
    Row{kTimeLeft, {"%s left", "noch %s"}},

    Row{kProfile, {"Profile", "Profil"}},
    Row{kSize, {"Height", "Höhe"}},
    Row{kTurn, {"Turn", "Drehen"}},
    Row{kTilt, {"Tilt", "Kippen"}},
    Row{kUpright, {"Orientation", "Beste Lage"}},
    Row{kSupports, {"Supports", "Stützen"}},
    Row{kLayerHeight, {"Layer height", "Schichthöhe"}},
    Row{kAsScanned, {"as scanned", "wie gescannt"}},
    Row{kOfProfile, {"as in profile", "wie im Profil"}},
    Row{kYes, {"yes", "ja"}},
    Row{kNo, {"no", "nein"}},

    Row{kCheckMemory, {"Memory", "Speicher"}},
    Row{kCheckObject, {"Object", "Objekt"}},
    Row{kCheckMasks, {"Layers", "Schichten"}},
    Row{kCheckLight, {"Light", "Licht"}},
    Row{kCheckLampDark, {"Lamp dark", "Lampe dunkel"}},
    Row{kCheckPanel, {"Panel", "LCD"}},
    Row{kCheckCover, {"Cover", "Haube"}},
    Row{kCheckTemperatures, {"Heat", "Wärme"}},
    Row{kCheckResin, {"Resin", "Harz"}},
    Row{kCheckJournal, {"Journal", "Journal"}},
    Row{kCheckStage, {"Z stage", "Z-Achse"}},

    Row{kLightReady, {"Ready", "Bereit"}},
    Row{kLightPrinting, {"Printing", "Druck"}},
    Row{kLightAttention, {"Attention", "Achtung"}},
    Row{kLightFault, {"Fault", "Fehler"}},
    Row{kBuzzer, {"Buzzer", "Summer"}},
    Row{kLightOn, {"on", "an"}},
    Row{kLightBlinks, {"blinks", "blinkt"}},
    Row{kLightOff, {"-", "-"}},
    Row{kBuzzes, {"1 s", "1 s"}},
    Row{kMeansReady, {"Ready: plug in a stick.", "Bereit: einen Stick einstecken."}},
    Row{kMeansOffered,
        {"▶ prints what is on the stick, ✖ declines it.", "▶ druckt, was auf dem Stick ist, ✖ lässt es."}},
    Row{kMeansBusy, {"Reading, checking or moving: wait.", "Liest, prüft oder fährt: warten."}},
    Row{kMeansPrinting, {"Printing: keep the cover closed.", "Druckt: Haube geschlossen lassen."}},
    Row{kMeansPaused, {"Paused: close the cover, then press ▶.", "Pause: Haube schließen, dann setzt ▶ fort."}},
    Row{kMeansResin,
        {"Resin is low: fill the tank, close the cover, then press ▶.",
         "Wenig Harz: Tank füllen, Haube schließen, dann ▶ drücken."}},
    Row{kMeansInterrupted,
        {"A print was interrupted: ▶ resumes it, ✖ abandons it.",
         "Ein Druck wurde unterbrochen: ▶ setzt ihn fort, ✖ gibt ihn auf."}},
    Row{kMeansFinished, {"Finished: take the part off.", "Fertig: das Teil abnehmen."}},
    Row{kMeansPlate,
        {"Is the plate empty and back in? Then press ▶.",
         "Ist die Platte leer und wieder eingesetzt? Dann ▶ drücken."}},
    Row{kMeansFault,
        {"A fault: the screen says what to do. Then press ▶.",
         "Ein Fehler: Der Schirm sagt, was hilft. Dann ▶ drücken."}},
    Row{kMeansEnd, {"A print has just ended, or the printer is off.", "Kurz an einem Ende, oder der Drucker ist aus."}},

    Row{kDoPrint, {"Print", "Drucken"}},
    Row{kDoNext, {"Next", "Weiter"}},
    Row{kDoDecline, {"Not now", "Ablehnen"}},
    Row{kDoOffer, {"Show", "Zeigen"}},
    Row{kDoOpen, {"Open", "Öffnen"}},
    Row{kDoChange, {"Change", "Ändern"}},
    Row{kDoBack, {"Back", "Zurück"}},
    Row{kDoStop, {"Stop", "Abbrechen"}},
    Row{kDoMore, {"More", "Mehr"}},
    Row{kDoPause, {"Pause", "Pause"}},
    Row{kDoCancel, {"Cancel", "Abbrechen"}},
    Row{kDoKeepPrinting, {"Continue", "Weiter"}},
    Row{kDoEndPrint, {"End print", "Beenden"}},
    Row{kDoDelete, {"Delete", "Löschen"}},
    Row{kDoResume, {"Resume", "Weiter"}},
    Row{kDoGiveUp, {"Abandon", "Aufgeben"}},
    Row{kDoEmpty, {"It's empty", "Leer"}},
    Row{kDoSeen, {"OK", "Gelesen"}},
    Row{kDoPrints, {"Prints", "Drucke"}},
    Row{kDoLights, {"Lights", "Lichter"}},

    Row{kPageCode, {"Page code: %s", "Code der Seite: %s"}},

    Row{kProposals, {"Best orientations", "Beste Lagen"}},
    Row{kProposing, {"Finding orientations", "Lagen werden gesucht"}},
    Row{kUnturned, {"Original", "Original"}},
    Row{kProposal, {"No. %u", "Lage %u"}},
    Row{kProposalUnits,
        {"Volume to support in ml (orange), height in mm, largest layer in cm²",
         "Zu stützender Raum in ml (orange), Höhe in mm, größte Schicht in cm²"}},
    Row{kDoTake, {"Use", "Nehmen"}},

    Row{kContract, {"What will be done", "Was gemacht wird"}},
    Row{kDoValues, {"Values", "Werte"}},
    Row{kDoRaise, {"+", "+"}},
    Row{kDoLower, {"-", "-"}},
};

}  // namespace words_table

using words_table::kTexts;

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < kTexts.size(); ++i) {
    if (kTexts[i].which != static_cast<Words>(i)) return false;
  }
  return kTexts.size() == kWordsCount;
}
static_assert(is_in_order());

}  // namespace

std::string_view words(Words which, Language language) {
  return kTexts[static_cast<std::size_t>(which)].text[static_cast<std::size_t>(language)];
}

}  // namespace plumbline
