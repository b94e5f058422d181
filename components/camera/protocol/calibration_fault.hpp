// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::camera {

/// Why a calibration cannot be used. Problem::where is the line of the file, the field of a message, or the parameter camera_info_url.
enum class CalibrationFault : std::uint8_t {
  UnsupportedUrl,  ///< The URL names no file: another scheme, or a path that is not absolute. Value: the URL.
  Malformed,       ///< The file is no YAML, or no map.
  MissingKey,      ///< A key is missing. Value: the key.
  NotANumber,      ///< A number is expected. Value: the text.
  OutOfRange,      ///< A number is negative, too large, or not whole. Value: the number.
  WrongShape,  ///< A matrix has another number of rows, columns or elements than its key or model needs. Value: the number.
  UnknownModel,  ///< The distortion model is not known. Value: its name.
  WrongSize,     ///< It is for images of another size. Value: the size.
  NoFile,        ///< A calibration is to be stored, and no file is named for it.
  NoStream,      ///< A calibration is to be stored, and the size of the images is not known yet.
};
[[nodiscard]] constexpr const char* code_text(CalibrationFault fault) {
  switch (fault) {
    case CalibrationFault::UnsupportedUrl: return "calibration.unsupported_url";
    case CalibrationFault::Malformed: return "calibration.malformed";
    case CalibrationFault::MissingKey: return "calibration.missing_key";
    case CalibrationFault::NotANumber: return "calibration.not_a_number";
    case CalibrationFault::OutOfRange: return "calibration.out_of_range";
    case CalibrationFault::WrongShape: return "calibration.wrong_shape";
    case CalibrationFault::UnknownModel: return "calibration.unknown_model";
    case CalibrationFault::WrongSize: return "calibration.wrong_size";
    case CalibrationFault::NoFile: return "calibration.no_file";
    case CalibrationFault::NoStream: return "calibration.no_stream";
  }
  return "";
}

}  // namespace nacelle::camera
