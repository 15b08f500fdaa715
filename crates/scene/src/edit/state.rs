//! What edits do to the objects, lamps and materials of a state, once their files are read.

use crate::{
    Lamp, Material, Object, Pose, SceneError,
    configuration::{Slot, State},
    load::{MOST_CELLS, own_name, printable},
    unknown,
};
use glam::DVec3;
use std::sync::Arc;

fn new_name(kind: &str, name: &str) -> Result<(), SceneError> {
    if printable(name) {
        return Ok(());
    }
    Err(SceneError::Edit(format!("the name {name:?} of a new {kind}: names must be printable and not empty")))
}

impl State {
    pub fn movable(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        let object = self.object(name)?;
        if object.movable {
            return Ok(object);
        }
        Err(SceneError::Edit(format!("object '{name}' is fixed; give it `movable: true` in the scene file")))
    }

    pub fn object(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        let id = self.object_id(name)?;
        Ok(Arc::make_mut(&mut self.objects[id].thing))
    }

    pub fn lamp(&mut self, name: &str) -> Result<&mut Lamp, SceneError> {
        let id = self.lamp_id(name)?;
        Ok(Arc::make_mut(&mut self.lamps[id].thing))
    }

    /// A lamp's light must be a number, also when it is switched off.
    pub fn countable(&mut self, name: &str) -> Result<(), SceneError> {
        let lit = Lamp { lit: true, ..self.lamp(name)?.clone() };
        let countable = lit.intensity.is_finite() && lit.flux().is_finite() && lit.rated_flux().is_finite();
        if countable && lit.intensity.min_element() >= 0.0 {
            return Ok(());
        }
        let what = format!("lamp '{name}': intensity {} must be candela, not below 0 and a number", lit.intensity);
        Err(SceneError::Edit(what))
    }

    /// Carriers form no ring.
    pub fn put(&mut self, name: &str, on: Option<&str>, pose: Pose) -> Result<(), SceneError> {
        self.movable(name)?;
        let id = self.object_id(name)?;
        let carrier = on.map(|on| self.object_id(on)).transpose()?;
        let mut below = carrier;
        while let Some(at) = below {
            if at == id {
                let on = on.unwrap_or_default();
                let why = if on == name { "itself".into() } else { format!("'{on}', which rides on it") };
                return Err(SceneError::Edit(format!("object '{name}' cannot be put on {why}")));
            }
            below = self.objects[at].thing.carrier;
        }
        let object = self.object(name)?;
        (object.carrier, object.entry.on, object.pose) = (carrier, on.map(str::to_owned), pose);
        Ok(())
    }

    pub fn material(&self, name: &str) -> Result<&Arc<Material>, SceneError> {
        let known = self.materials.keys().map(String::as_str);
        self.materials.get(name).ok_or_else(|| SceneError::Edit(unknown("material", name, known)))
    }

    /// The objects that are there and use a material.
    pub fn made_of(&self, material: &str) -> impl Iterator<Item = &Object> {
        let present = self.objects.iter().filter(|slot| slot.present).map(|slot| &*slot.thing);
        present.filter(move |object| object.materials.iter().any(|m| m.name == material))
    }

    pub fn reflect(&mut self, name: &str, to: DVec3) -> Result<(), SceneError> {
        if !(to.is_finite() && to.min_element() >= 0.0 && to.max_element() <= 1.0) {
            return Err(SceneError::Edit(format!("material '{name}': reflectance {to} must be within 0 to 1")));
        }
        self.remake(name, |old| Material { reflectance: to.as_vec3(), ..old })
    }

    /// Changes a material wherever it is used.
    pub fn remake(&mut self, name: &str, change: impl FnOnce(Material) -> Material) -> Result<(), SceneError> {
        let new = Arc::new(change(Material::clone(self.material(name)?)));
        for slot in &mut self.objects {
            if slot.thing.materials.iter().any(|m| m.name == name) {
                let uses = Arc::make_mut(&mut slot.thing).materials.iter_mut().filter(|m| m.name == name);
                uses.for_each(|m| *m = new.clone());
            }
        }
        self.materials.insert(name.to_owned(), new);
        Ok(())
    }

    pub fn new_material(&self, name: &str) -> Result<(), SceneError> {
        new_name("material", name)?;
        if self.materials.contains_key(name) {
            return Err(SceneError::Edit(format!("there is a material '{name}' already; give the new one another name")));
        }
        // When the object is read again its material must not turn into this one.
        let mut own =
            self.objects.iter().filter(|slot| slot.present && slot.thing.entry.material.is_none()).map(|slot| &slot.thing);
        let kept = |object: &Object| object.mesh.materials.iter().any(|own| own_name(own, &object.entry.mesh) == name);
        match own.find(|object| kept(object)) {
            None => Ok(()),
            Some(object) => {
                let what =
                    format!("the name '{name}' is kept for a material of object '{}'; give the new one another", object.name);
                Err(SceneError::Edit(what))
            }
        }
    }

    pub fn add_material(&mut self, material: Material) {
        // What says the same as a mesh's own file still counts as the mesh's, so that undoing leaves no trace.
        if self.of_meshes.get(&material.name).is_some_and(|own| **own != material) {
            self.of_meshes.remove(&material.name);
        }
        self.materials.insert(material.name.clone(), Arc::new(material));
    }

    pub fn remove_material(&mut self, name: &str) -> Result<(), SceneError> {
        self.material(name)?;
        if let Some(object) = self.made_of(name).next() {
            let what = format!("material '{name}' is used by object '{}'; paint that first", object.name);
            return Err(SceneError::Edit(what));
        }
        self.materials.remove(name);
        Ok(())
    }

    /// A removed object that comes back takes its old place, so that undoing leaves no trace.
    pub fn add_object(&mut self, mut object: Object) -> Result<(), SceneError> {
        if self.object_id(&object.name).is_ok() {
            return Err(SceneError::Edit(format!("there is an object '{}' already; give the new one another name", object.name)));
        }
        new_name("object", &object.name)?;
        let present = self.objects.iter().filter(|slot| slot.present).map(|slot| &*slot.thing);
        let cells: u64 = present.chain([&object]).map(|o| u64::from(o.lattice.cells())).sum();
        if cells > MOST_CELLS {
            let what = format!("object '{}': with it there would be {cells} mesh elements, more than {MOST_CELLS}", object.name);
            return Err(SceneError::Edit(what));
        }
        object.dynamic |= object.carrier.is_some_and(|id| self.objects[id].thing.dynamic);
        let place = self.objects.iter_mut().find(|s| !s.present && s.thing.name == object.name && s.thing.mesh == object.mesh);
        match place {
            Some(slot) => {
                // One lattice for one slot: cells keep their numbers. One mesh: it is seen at a glance that it is the same.
                (object.mesh, object.lattice) = (slot.thing.mesh.clone(), slot.thing.lattice.clone());
                *slot = Slot { thing: Arc::new(object), present: true };
            }
            None => self.objects.push(Slot { thing: Arc::new(object), present: true }),
        }
        Ok(())
    }

    pub fn add_lamp(&mut self, lamp: Lamp) -> Result<(), SceneError> {
        if self.lamp_id(&lamp.name).is_ok() {
            return Err(SceneError::Edit(format!("there is a lamp '{}' already; give the new one another name", lamp.name)));
        }
        new_name("lamp", &lamp.name)?;
        let new = Slot { thing: Arc::new(lamp), present: true };
        match self.lamps.iter_mut().find(|s| !s.present && s.thing.name == new.thing.name) {
            Some(slot) => *slot = new,
            None => self.lamps.push(new),
        }
        Ok(())
    }

    pub fn remove(&mut self, name: &str) -> Result<(), SceneError> {
        let id = self.object_id(name)?;
        self.objects[id].present = false;
        let rides_on_nothing = |carrier: Option<usize>, objects: &[Slot<Object>]| carrier.is_some_and(|c| !objects[c].present);
        // Riders of riders follow, one layer a round.
        loop {
            let next = self.objects.iter().position(|s| s.present && rides_on_nothing(s.thing.carrier, &self.objects));
            let Some(rider) = next else { break };
            self.objects[rider].present = false;
        }
        for slot in &mut self.lamps {
            slot.present &= !rides_on_nothing(slot.thing.carrier, &self.objects);
        }
        Ok(())
    }
}
