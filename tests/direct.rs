//! Direct light against closed forms.
