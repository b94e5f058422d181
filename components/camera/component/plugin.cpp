// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::camera::CameraComponent)
