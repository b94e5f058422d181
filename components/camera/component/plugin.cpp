// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::camera::CameraComponent>{
    .purpose =
        "Publishes the images of a camera, or a test pattern. Once the camera is open, each of its controls "
        "(brightness, exposure_auto, ...) is a parameter of that name.",
    .devices =
        "V4L2 cameras that send YUYV, UYVY, RGB3, BGR3, MJPG, JPEG, NV12, GREY or Bayer mosaics of 8 bit; "
        "cameras of libcamera, with the package nacelle-libcamera",
    .also_with = "pixel_format:=MJPG"};

NACELLE_REGISTER_COMPONENT(nacelle::camera::CameraComponent)
